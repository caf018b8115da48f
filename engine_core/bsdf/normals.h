// Shading normals against the geometry: correction and shadowing.
#pragma once

#include "bsdf/microfacet.h"
#include "math/vec.h"

namespace vernier {

// The mirror image of v about the plane of unit normal n.
inline Vec3f mirror(Vec3f v, Vec3f n) { return v - n * (2.0f * dot(v, n)); }
// The perfect reflection of v at unit normal n.
inline Vec3f reflect(Vec3f v, Vec3f n) { return n * (2.0f * dot(v, n)) - v; }

// A mirror whose normal n differs from the surface's ng can reflect d (d.ng >= 0) into the
// surface. Then n is turned toward ng until the reflection r just leaves it, at
// r.ng = t = min(0.9 d.ng, 0.01), as Cycles does. In the plane of n and ng, with x and z the
// coordinates along n - (n.ng) ng and along ng, the new normal solves
//   2 (x d_x + z d_z) z - d_z = t,  x^2 + z^2 = 1,
// a quadratic equation in z^2 after squaring, of which the root is taken that solves this one too.
inline Vec3f valid_normal(Vec3f ng, Vec3f d, Vec3f n) {
  const float dz = dot(d, ng);
  const float threshold = std::min(0.9f * dz, 0.01f);
  if (dot(ng, reflect(d, n)) >= threshold) {
    return n;
  }
  const Vec3f across = n - ng * dot(n, ng);
  const float length2 = length_squared(across);
  if (!(length2 > 0.0f)) {
    return ng;
  }
  const Vec3f x = across * (1.0f / std::sqrt(length2));
  const float dx = dot(d, x);
  const float a = dx * dx + dz * dz;
  if (!(a > 0.0f)) {
    return ng;
  }
  const float b = 2.0f * (a + dz * threshold);
  const float c = square(threshold + dz);
  const float root = safe_sqrt(b * b - 4.0f * a * c);
  const float z2 = std::min(0.25f * (dx < 0.0f ? b + root : b - root) / a, 1.0f);
  return x * safe_sqrt(1.0f - z2) + ng * safe_sqrt(z2);
}

// Squared GGX alpha of the bump that turned ns into n (Conty Estevez, Lecocq and Stein 2019, "A
// Microfacet-Based Shadowing Function to Solve the Bump Terminator Problem").
inline float bump_alpha2(Vec3f n, Vec3f ns) {
  const float cos2 = square(dot(n, ns));
  return cos2 > 0.0f ? saturate(0.125f * (1.0f / cos2 - 1.0f)) : 1.0f;
}

// Their shadowing of light from l at a bump, zero where l and n disagree about the side of ns.
inline float bump_shadowing(Vec3f n, Vec3f ns, Vec3f l, float alpha2) {
  const float cos_ns = dot(ns, l);
  if (cos_ns * dot(ns, n) * dot(n, l) < 0.0f) {
    return 0.0f;
  }
  const float c = std::abs(cos_ns);
  // G1 = cos / (cos + m): zero at grazing incidence without dividing by the cosine.
  const float m = ggx_masking(alpha2 * std::max(1.0f - c * c, 0.0f), c);
  return c > 0.0f ? c / (c + m) : 0.0f;
}

}  // namespace vernier
