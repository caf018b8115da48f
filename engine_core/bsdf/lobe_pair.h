// Value and densities of one lobe for a pair of directions.
#pragma once

#include "bsdf/layering.h"
#include "bsdf/lobe.h"
#include "bsdf/microfacet_lobe.h"
#include "bsdf/normals.h"
#include "bsdf/oren_nayar.h"
#include "bsdf/sheen.h"

namespace vernier {

// Microfacets of a mirrored lobe: the other direction is seen in the mirror of the normal.
inline Vec3f seen_through(const Lobe& lobe, Vec3f n, Vec3f v) {
  return lobe.mirrored ? mirror(v, n) : v;
}

// Ashikhmin's velvet without the cosine at l: D G / (4 cos_c cos_l) (Ashikhmin, Premoze and Shirley
// 2000, "A Microfacet-based BRDF Generator"). Both cosines are positive.
inline float velvet(float sigma, Vec3f n, Vec3f c, Vec3f l) {
  const float cos_c = dot(n, c), cos_l = dot(n, l);
  const Vec3f h = normalize(c + l);
  const float cos_h = dot(n, h), c_h = dot(c, h);
  const float sin2 = length_squared(cross(n, h));
  if (!(sin2 > 0.0f && c_h > 0.0f && cos_h > 0.0f)) {
    return 0.0f;
  }
  const float inverse = 1.0f / (sigma * sigma);
  // At least sigma 0.01: the exponential vanishes long before sin2^2 does.
  const float d = std::exp(-square(cos_h) / sin2 * inverse) * inverse * kInvPi / square(sin2);
  const float g = std::min(1.0f, 2.0f * (cos_h / c_h) * std::min(cos_c, cos_l));
  return 0.25f * d * g / cos_c;
}

// Share of light inside a toon lobe of the given angular size and smooth border.
inline float toon_step(float size, float smooth, float angle) {
  return angle < size ? 1.0f : (angle < size + smooth ? 1.0f - (angle - size) / smooth : 0.0f);
}
inline float toon_cone(const Lobe& lobe) {
  return std::min(lobe.alpha_x + lobe.alpha_y, kPi / 2.0f);
}
// 1 - cos(angle), with all digits for small angles.
inline float one_minus_cos(float angle) { return 2.0f * square(std::sin(0.5f * angle)); }
// Angle between unit vectors, accurate for small ones (Kahan).
inline float angle_between(Vec3f a, Vec3f b) {
  return 2.0f * std::atan2(length(a - b), length(a + b));
}

// Ashikhmin and Shirley 2000, "An Anisotropic Phong BRDF Model", without Fresnel. Value with the
// cosine at l, and the density of l given c, which is symmetric.
inline LobePair evaluate_ashikhmin_shirley(const Lobe& lobe, Vec3f n, Vec3f c, Vec3f l) {
  const float cos_c = dot(n, c), cos_l = dot(n, l);
  if (!(cos_c > 0.0f && cos_l > 0.0f)) {
    return {};
  }
  const Vec3f h = normalize(c + l);
  const float c_h = dot(c, h), cos_h = dot(n, h);
  if (!(c_h > 0.0f && cos_h > 0.0f)) {
    return {};
  }
  const float n_x = 2.0f / square(lobe.alpha_x) - 2.0f, n_y = 2.0f / square(lobe.alpha_y) - 2.0f;
  const float sin2 = length_squared(cross(n, h));
  float exponent = n_x;
  if (n_x != n_y && sin2 > 0.0f) {
    const Vec3f lh = Frame(n, lobe.tangent).to_local(h);
    exponent = (n_x * square(lh.x) + n_y * square(lh.y)) / (square(lh.x) + square(lh.y));
  }
  // cos_h^e as (1 - sin^2)^(e/2): cos_h has no digits left where e is large.
  const float peak = std::exp(0.5f * exponent * std::log1p(-std::min(sin2, kOneMinusEpsilon)));
  const float norm = std::sqrt((n_x + 1.0f) * (n_y + 1.0f)) * (kInvPi / 8.0f);
  const float density = norm * peak / c_h;
  return {splat(density * cos_l / std::max(cos_c, cos_l)), density, density};
}

// The part of evaluate_lobe for lobes without microfacets.
inline LobePair evaluate_facetless(const Lobe& lobe, const LobeSide& seen,
                                   const SurfaceSide& camera, const SurfaceSide& light, Vec3f ns) {
  const Vec3f n = seen.normal, c = camera.d, l = light.d;
  LobePair pair;
  switch (lobe.kind) {
    case LobeKind::kAshikhminShirley:
      return evaluate_ashikhmin_shirley(lobe, n, c, l);
    case LobeKind::kGlossyToon: {
      if (dot(n, c) > 0.0f && dot(n, l) > 0.0f) {
        const float angle = angle_between(reflect(c, n), l);
        const float cone = toon_cone(lobe);
        if (angle < cone) {
          pair.pdf_s = pair.pdf_g = kInvTwoPi / one_minus_cos(cone);
          pair.f = splat(pair.pdf_s * toon_step(lobe.alpha_x, lobe.alpha_y, angle));
        }
      }
      return pair;
    }
    default:
      break;
  }
  pair.pdf_g = std::max(dot(camera.ng, c), 0.0f) * kInvPi;
  const float cos_l = lobe.mirrored ? -dot(n, l) : dot(n, l);
  if (!(cos_l > 0.0f)) {
    return pair;
  }
  pair.pdf_s = cos_l * kInvPi;
  switch (lobe.kind) {
    case LobeKind::kLambert:
      pair.f = splat(pair.pdf_s);
      break;
    case LobeKind::kOrenNayar: {
      const OrenNayar model(lobe.alpha_x);
      const float cos_c = std::max(dot(n, c), 0.0f);
      const float single = model.single_scattering(cos_c, cos_l, dot(c, seen_through(lobe, n, l)));
      pair.f = splat(single) + lobe.f0 * ((1.0f - seen.a) * (1.0f - model.albedo(cos_l)) * cos_l);
    } break;
    case LobeKind::kSheen: {
      const float value = sheen_density(seen.a, seen.b, Frame(n, c).to_local(l));
      pair.pdf_s = value;
      pair.f = splat(value);
    } break;
    case LobeKind::kVelvet:
      pair.pdf_s = kInvTwoPi;
      pair.f = splat(dot(n, c) > 0.0f ? velvet(lobe.alpha_x, n, c, l) : 0.0f);
      break;
    case LobeKind::kDiffuseToon: {
      const float angle = angle_between(n, l);
      const float cone = toon_cone(lobe);
      pair.pdf_s = angle < cone ? kInvTwoPi / one_minus_cos(cone) : 0.0f;
      pair.f = splat(pair.pdf_s * toon_step(lobe.alpha_x, lobe.alpha_y, angle));
    } break;
    default:
      break;
  }
  if (lobe.bumped) {
    pair.f *= bump_shadowing(n, ns, l, lobe.bump_alpha2);
  }
  return pair;
}

// F(c, l) less the scale, and densities. Diffuse lobes sample l from the camera's side by their own
// shape about n, and c from the light's side by the cosine about ng: exact for Lambert, since there
// F(c, l) |c.ng| / |l.ng| does not otherwise depend on c, and free of samples below the surface.
inline LobePair evaluate_lobe(const Lobe& lobe, const LobeSide& seen, const SurfaceSide& camera,
                              const SurfaceSide& light, Vec3f ns, bool transmit,
                              AllowedEvents allowed) {
  if (!is_microfacet(lobe.kind)) {
    return evaluate_facetless(lobe, seen, camera, light, ns);
  }
  return evaluate_microfacet(
      lobe, seen.normal, eta_from(lobe, camera.sign), film_ior_from(lobe, camera.sign), camera.d,
      seen_through(lobe, seen.normal, light.d), transmit && !lobe.mirrored, allowed);
}

// Whether pdf_g must be computed anew from the light's side: its normal was corrected otherwise, or
// its film's approximate Fresnel term differs.
inline bool depends_on_side(const Lobe& lobe, bool transmit, Vec3f camera_normal,
                            Vec3f light_normal) {
  return (lobe.corrected && !(camera_normal == (transmit ? -light_normal : light_normal))) ||
         (transmit && lobe.kind == LobeKind::kGlass && lobe.film.thickness > kNoFilm);
}

}  // namespace vernier
