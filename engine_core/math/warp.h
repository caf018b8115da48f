// Mappings from the unit square to the domains that rendering samples, with their densities.
#pragma once

#include "math/frame.h"
#include "math/vec.h"

namespace vernier {

// Sine and cosine of an angle between -pi/4 and pi/4, good to an ulp (the polynomials of Moshier's
// Cephes library, sinf.c).
inline Vec2f cos_sin_of_octant(float x) {
  const float z = x * x;
  const float sine =
      ((-1.9515295891e-4f * z + 8.3321608736e-3f) * z - 1.6666654611e-1f) * z * x + x;
  const float cosine =
      ((2.443315711809948e-5f * z - 1.388731625493765e-3f) * z + 4.166664568298827e-2f) * z * z -
      0.5f * z + 1.0f;
  return {cosine, sine};
}

// Unit disk, area preserving and continuous (Shirley and Chiu 1997). Density 1/pi. Which of the two
// coordinates is larger could not be foretold, so nothing branches on it: both cases are one octant
// and its mirror image.
inline Vec2f square_to_disk(Vec2f u) {
  const float a = 2.0f * u.x - 1.0f;
  const float b = 2.0f * u.y - 1.0f;
  const bool along_x = std::abs(a) > std::abs(b);
  const float r = along_x ? a : b, other = along_x ? b : a;
  const Vec2f d = cos_sin_of_octant((kPi / 4.0f) * (r != 0.0f ? other / r : 0.0f));
  return {r * (along_x ? d.x : d.y), r * (along_x ? d.y : d.x)};
}

// Hemisphere about +z in proportion to the cosine (Malley's method). Density cos/pi.
inline Vec3f square_to_cosine_hemisphere(Vec2f u) {
  const Vec2f d = square_to_disk(u);
  return {d.x, d.y, safe_sqrt(1.0f - d.x * d.x - d.y * d.y)};
}
inline float cosine_hemisphere_pdf(float cos_theta) { return std::max(cos_theta, 0.0f) * kInvPi; }

// Hemisphere about +z. Density 1/(2 pi).
inline Vec3f square_to_uniform_hemisphere(Vec2f u) {
  const float z = 1.0f - u.y;
  const float r = safe_sqrt(u.y * (2.0f - u.y));
  const float phi = kTwoPi * u.x;
  return {r * std::cos(phi), r * std::sin(phi), z};
}

// Sphere. Density 1/(4 pi).
inline Vec3f square_to_uniform_sphere(Vec2f u) {
  const float z = 1.0f - 2.0f * u.y;
  const float r = 2.0f * safe_sqrt(u.y * (1.0f - u.y));
  const float phi = kTwoPi * u.x;
  return {r * std::cos(phi), r * std::sin(phi), z};
}

// Cone of half angle theta about +z, given 1 - cos(theta), which keeps its digits for small cones
// where cos(theta) has none. Density uniform_cone_pdf(one_minus_cos).
inline Vec3f square_to_uniform_cone(Vec2f u, float one_minus_cos) {
  const float h = u.y * one_minus_cos;  // 1 - z
  const float r = safe_sqrt(h * (2.0f - h));
  const float phi = kTwoPi * u.x;
  return {r * std::cos(phi), r * std::sin(phi), 1.0f - h};
}
inline float uniform_cone_pdf(float one_minus_cos) { return kInvTwoPi / one_minus_cos; }

// Barycentric coordinates (b1, b2) uniform over a triangle with low distortion
// (Heitz 2019, "A Low-Distortion Map Between Triangle and Square").
inline Vec2f square_to_triangle(Vec2f u) {
  if (u.y > u.x) {
    const float b1 = u.x * 0.5f;
    return {b1, u.y - b1};
  }
  const float b2 = u.y * 0.5f;
  return {u.x - b2, b2};
}

}  // namespace vernier
