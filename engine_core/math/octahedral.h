// The area-preserving octahedral map between the unit square and the sphere.
#pragma once

#include "math/vec.h"

namespace vernier {

// Equal areas of the square become equal solid angles (Clarberg 2008, "Fast Equal-Area Mapping of
// the (Hemi)Sphere using SIMD"). The density of a uniform point is 1/(4 pi).
inline Vec3f square_to_sphere_equal_area(Vec2f p) {
  const float u = 2.0f * p.x - 1.0f;
  const float v = 2.0f * p.y - 1.0f;
  const float inside = 1.0f - (std::abs(u) + std::abs(v));  // > 0: the upper half
  const float r = 1.0f - std::abs(inside);
  const float phi = (kPi / 4.0f) * (r == 0.0f ? 1.0f : (std::abs(v) - std::abs(u)) / r + 1.0f);
  const float s = r * std::sqrt(2.0f - r * r);
  return {std::copysign(std::cos(phi) * s, u), std::copysign(std::sin(phi) * s, v),
          std::copysign(1.0f - r * r, inside)};
}

// The inverse; d is of unit length.
inline Vec2f sphere_to_square_equal_area(Vec3f d) {
  const float x = std::abs(d.x);
  const float y = std::abs(d.y);
  // sqrt(1 - |z|), without its cancellation near the poles.
  const float r = std::sqrt((x * x + y * y) / (1.0f + std::abs(d.z)));
  float v = r * (x == 0.0f && y == 0.0f ? 0.0f : std::atan2(y, x) * (2.0f / kPi));
  float u = r - v;
  if (d.z < 0.0f) {
    const float w = u;
    u = 1.0f - v;
    v = 1.0f - w;
  }
  return {clamp(0.5f * (std::copysign(u, d.x) + 1.0f), 0.0f, kOneMinusEpsilon),
          clamp(0.5f * (std::copysign(v, d.y) + 1.0f), 0.0f, kOneMinusEpsilon)};
}

}  // namespace vernier
