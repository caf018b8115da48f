// Sampling of Beckmann's visible normals by inversion of the slopes' distribution (Heitz and d'Eon
// 2014, "Importance Sampling Microfacet-Based BSDFs using the Distribution of Visible Normals").
#include "bsdf/microfacet.h"

namespace vernier {
namespace {

constexpr float kInvSqrtPi = 0.56418958354775628695f;
// Slopes are standard normal with variance 1/2: beyond this none is left in float32.
constexpr float kSlopeLimit = 4.5f;

// Root of a monotone increasing f on [lo, hi] by Newton's steps, bisecting where these leave the
// bracket. f gives {value, derivative}.
template <typename F>
float solve(float lo, float hi, float start, F&& f) {
  float x = start;
  for (int i = 0; i < 24; ++i) {
    const auto [value, slope] = f(x);
    if (value > 0.0f) {
      hi = x;
    } else {
      lo = x;
    }
    const float newton = x - value / slope;
    const float next = newton > lo && newton < hi ? newton : 0.5f * (lo + hi);
    if (std::abs(next - x) < 1e-6f) {
      return next;
    }
    x = next;
  }
  return x;
}

struct ValueSlope {
  float value, slope;
};

// Slope with density exp(-x^2)/sqrt(pi).
float sample_slope(float u) {
  return solve(-kSlopeLimit, kSlopeLimit, 0.0f, [u](float x) {
    return ValueSlope{0.5f * std::erfc(-x) - u, std::exp(-x * x) * kInvSqrtPi};
  });
}

// Slope along the view, of density proportional to max(cos - x sin, 0) exp(-x^2).
float sample_visible_slope(float cos_v, float sin_v, float u) {
  const float top = sin_v * kSlopeLimit > cos_v ? cos_v / sin_v : kSlopeLimit;
  const auto cumulative = [cos_v, sin_v](float x) {
    return 0.5f * (cos_v * std::erfc(-x) + sin_v * std::exp(-x * x) * kInvSqrtPi);
  };
  const float target = u * cumulative(top);
  return solve(-kSlopeLimit, top, std::min(0.0f, 0.5f * (top - kSlopeLimit)), [&](float x) {
    return ValueSlope{cumulative(x) - target,
                      std::max((cos_v - x * sin_v) * std::exp(-x * x) * kInvSqrtPi, 1e-30f)};
  });
}

}  // namespace

Vec3f sample_beckmann_visible(Vec3f v, float alpha_x, float alpha_y, Vec2f u) {
  const Vec3f s = normalize(Vec3f{alpha_x * v.x, alpha_y * v.y, v.z});
  const float sin_v = std::sqrt(s.x * s.x + s.y * s.y);
  const float along = sample_visible_slope(s.z, sin_v, u.x);
  const float across = sample_slope(u.y);
  const float cos_phi = sin_v > 0.0f ? s.x / sin_v : 1.0f;
  const float sin_phi = sin_v > 0.0f ? s.y / sin_v : 0.0f;
  // A slope x means the normal (-x, ., 1): facets tilted toward the viewer have negative slopes.
  const float x = cos_phi * along - sin_phi * across;
  const float y = sin_phi * along + cos_phi * across;
  return normalize(Vec3f{-alpha_x * x, -alpha_y * y, 1.0f});
}

}  // namespace vernier
