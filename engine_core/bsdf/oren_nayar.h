// Rough diffuse reflection: Fujii's improved Oren-Nayar with the energy compensation of OpenPBR
// (mimosa-pudica.net/improved-oren-nayar.html; OpenPBR specification 1.1, section 3.6.2).
#pragma once

#include "math/vec.h"

namespace vernier {

// Constants of the single-scattering part; alpha is roughness in [0, 1].
struct OrenNayar {
  float a, b;
  explicit OrenNayar(float roughness)
      : a(1.0f / (kPi + roughness * (kPi / 2.0f - 2.0f / 3.0f))), b(roughness * a) {}

  // Directional albedo of single scattering at the cosine of either direction.
  float albedo(float cos_v) const {
    const float c = clamp(cos_v, 0.0f, 1.0f);
    if (c < 1e-6f) {  // the limit, to first order: tan would overflow
      return a * kPi + b * (kPi / 2.0f - 2.0f / 3.0f - c);
    }
    const float s = std::sqrt(1.0f - c * c);
    const float g =
        s * (std::acos(c) - 2.0f / 3.0f - s * c) + (2.0f / 3.0f) * (s / c) * (1.0f - s * s * s);
    return a * kPi + b * g;
  }

  // Factor of (1 - albedo(c)) (1 - albedo(l)) cos(l) that light scattered between facets adds.
  Color multiple_scattering(Color color) const {
    const Color albedo{saturate(color.x), saturate(color.y), saturate(color.z)};
    const float average = a * kPi + ((kTwoPi - 5.6f) / 3.0f) * b;
    const float gain = kInvPi * average / (1.0f - average);
    return albedo * albedo * gain / (splat(1.0f) - albedo * (1.0f - average));
  }

  // Single scattering times cos_l. cos_l > 0, cos_c >= 0.
  float single_scattering(float cos_c, float cos_l, float cos_cl) const {
    const float t = cos_cl - cos_l * cos_c;
    return a * cos_l + b * t * (t > 0.0f ? cos_l / std::max(cos_l, cos_c) : cos_l);
  }
};

}  // namespace vernier
