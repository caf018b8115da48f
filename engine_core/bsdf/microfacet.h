// Microfacet distributions: GGX and Beckmann normals, Smith masking, sampling of visible normals.
//
// Masking is written with m(v) = cos(v) Lambda(v), which stays finite at grazing angles where
// Lambda does not: cos(c) / G2(c, l) = cos(c) + m(c) + m(l) cos(c) / cos(l), where G2 is the
// height-correlated masking and shadowing (Heitz 2014, "Understanding the Masking-Shadowing
// Function in Microfacet-Based BRDFs", equation 99).
#pragma once

#include "math/frame.h"
#include "math/vec.h"

namespace vernier {

// Below this product of alphas a surface is a perfect mirror, as in Cycles. Just above, the
// angular width 1.4e-5 is still some hundred times the rounding of a unit vector.
inline constexpr float kSingularAlphaProduct = 2e-10f;

// The squared tangential extents of a direction scaled by alpha: (alpha_x x)^2 + (alpha_y y)^2.
inline float stretched(float alpha_x, float alpha_y, Vec3f v) {
  return square(alpha_x * v.x) + square(alpha_y * v.y);
}

// GGX Lambda, isotropic (Heitz 2014, equation 72).
inline float ggx_lambda(float alpha2, float cos_v) {
  return 0.5f * (std::sqrt(1.0f + alpha2 * std::max(1.0f / square(cos_v) - 1.0f, 0.0f)) - 1.0f);
}
// m(v) of GGX, from the stretched extents and |cos v|.
inline float ggx_masking(float stretched_v, float cos_v) {
  const float root = std::sqrt(square(cos_v) + stretched_v);
  return 0.5f * stretched_v / (root + cos_v);  // (root - cos_v) / 2 without cancellation
}
// m(v) of Beckmann, exactly (Heitz 2014, equation 67). cos_v > 0.
inline float beckmann_masking(float stretched_v, float cos_v) {
  if (!(stretched_v > 0.0f)) {
    return 0.0f;
  }
  const float s = std::sqrt(stretched_v);
  const float a = cos_v / s;
  constexpr float kInvSqrtPi = 0.56418958354775628695f;
  return a > 4.0f
             ? 0.0f  // Lambda < 1e-9
             : std::max(0.5f * (s * std::exp(-a * a) * kInvSqrtPi - cos_v * std::erfc(a)), 0.0f);
}

// Densities of normals, D(h), from h's tangential slopes: `slopes` = (x/alpha_x)^2 + (y/alpha_y)^2
// for the unit vector h, and z2 = h.z^2.
inline float ggx_density(float alpha_product, float slopes, float z2) {
  return kInvPi / (alpha_product * square(slopes + z2));
}
inline float beckmann_density(float alpha_product, float slopes, float z2) {
  return z2 > 0.0f ? kInvPi * std::exp(-slopes / z2) / (alpha_product * square(z2)) : 0.0f;
}

// A normal of GGX visible from v (v.z > 0): a uniform point of the spherical cap that the stretched
// hemisphere reflects to (Dupuy and Benyoub 2023, "Sampling Visible GGX Normals with Spherical
// Caps"). Local coordinates; the result is unit.
inline Vec3f sample_ggx_visible(Vec3f v, float alpha_x, float alpha_y, Vec2f u) {
  const Vec3f s = normalize(Vec3f{alpha_x * v.x, alpha_y * v.y, v.z});
  const float phi = kTwoPi * u.x;
  const float z = (1.0f - u.y) * (1.0f + s.z) - s.z;
  const float r = safe_sqrt(1.0f - z * z);
  const Vec3f c{r * std::cos(phi) + s.x, r * std::sin(phi) + s.y, std::max(z + s.z, 0.0f)};
  return normalize(Vec3f{alpha_x * c.x, alpha_y * c.y, c.z});
}

// The same for Beckmann.
Vec3f sample_beckmann_visible(Vec3f v, float alpha_x, float alpha_y, Vec2f u);

}  // namespace vernier
