#include "bsdf/sheen.h"

namespace vernier {

// Rational fits to the simulated layers of microfibres, as published with the model's MaterialX
// implementation (MaterialX 1.39, "Zeltner sheen").
SheenTransform sheen_transform(float cos_v, float roughness) {
  const float x = saturate(cos_v), y = roughness;
  const float s = y * (0.0206607f + 1.58491f * y) / (0.0379424f + y * (1.32227f + y));
  const float m =
      y * (-0.193854f + y * (-1.14885f + y * (1.7932f - 0.95943f * y * y))) / (0.046391f + y);
  const float o =
      y * (0.000654023f + (-0.0207818f + 0.119681f * y) * y) / (1.26264f + y * (-1.92021f + y));
  SheenTransform t;
  constexpr float kInvSqrtTwoPi = 0.39894228f;
  t.albedo = saturate(std::exp(-0.5f * square((x - m) / s)) * kInvSqrtTwoPi / s + o);
  t.a = (2.58126f * x + 0.813703f * y) * y / (1.0f + 0.310327f * x * x + 2.60994f * x * y);
  t.b = safe_sqrt(1.0f - x) * (y - 1.0f) * y * y * y /
        (0.0000254053f + 1.71228f * x - 1.71506f * x * y + 1.34174f * y * y);
  return t;
}

}  // namespace vernier
