// Reflection and refraction at microfacets: Fresnel term, value and densities of one lobe.
#pragma once

#include "bsdf/fresnel.h"
#include "bsdf/lobe.h"
#include "bsdf/microfacet.h"
#include "bsdf/thin_film.h"
#include "math/frame.h"

namespace vernier {

inline bool is_microfacet(LobeKind kind) { return kind >= LobeKind::kReflection; }

// What is reflected and what is transmitted, with their tints.
struct FresnelSplit {
  Color r, t;
};

// Fresnel terms with thin films, which are rare and long.
FresnelSplit film_fresnel(const Lobe& lobe, float cos_h, float eta, float film_ior);

// At the cosine of the given direction with the facet, incident from the side whose relative index
// of what lies beyond is eta.
inline FresnelSplit lobe_fresnel(const Lobe& lobe, float cos_h, float eta, float film_ior) {
  if (lobe.film.thickness > kNoFilm) {
    return film_fresnel(lobe, cos_h, eta, film_ior);
  }
  switch (lobe.fresnel) {
    case FresnelKind::kNone: {
      if (lobe.kind != LobeKind::kRefraction) {
        return {splat(1.0f), {}};
      }
      const bool refracts = square(eta) - (1.0f - square(cos_h)) > 0.0f;
      return {{}, splat(refracts ? 1.0f : 0.0f)};
    }
    case FresnelKind::kDielectric:
      return {splat(fresnel_dielectric(cos_h, eta)), {}};
    case FresnelKind::kSchlick: {
      // How far the true reflectance has gone to 1 takes f0 as far to white (Cycles' generalised
      // Schlick term).
      const float curve = fresnel_dielectric(cos_h, eta);
      const Color f =
          lerp(lobe.f0, splat(1.0f), saturate((curve - lobe.true_f0) * lobe.blend_scale));
      return {f * lobe.reflection_tint, (splat(1.0f) - f) * lobe.transmission_tint};
    }
    case FresnelKind::kF82:
      return {fresnel_f82(cos_h, lobe.f0, lobe.b), {}};
    case FresnelKind::kConductor:
      return {fresnel_conductor(cos_h, lobe.f0, lobe.b), {}};
  }
  return {};
}

// Probability that a lobe reflects, where both events are allowed.
inline float reflect_probability(const FresnelSplit& f) {
  const float r = average(f.r), sum = r + average(f.t);
  return sum > 0.0f ? r / sum : 0.0f;
}
// The same where only some are.
inline float reflect_probability(const FresnelSplit& f, bool reflects, bool transmits) {
  return !transmits ? 1.0f : (!reflects ? 0.0f : reflect_probability(f));
}

// Which events of a lobe are allowed.
struct AllowedEvents {
  bool reflection, transmission;
};
// Those of its microfacets: a mirrored lobe's transmission is their reflection.
inline AllowedEvents facet_events(const Lobe& lobe, AllowedEvents allowed) {
  return lobe.mirrored ? AllowedEvents{true, false} : allowed;
}

// F(g, s) with g the camera's side, and the densities of sampling each direction given the other.
struct LobePair {
  Color f;
  float pdf_s = 0.0f;  // of s given g
  float pdf_g = 0.0f;  // of g given s
};

// `n` is on g's side, `eta` the index beyond the surface over g's. pdf_g assumes that n and the
// Fresnel term are the same seen from s. Walter et al. 2007, "Microfacet Models for Refraction
// through Rough Surfaces", equations 20 and 21 (without the squared index: see bsdf.h).
inline LobePair evaluate_microfacet(const Lobe& lobe, Vec3f n, float eta, float film_ior, Vec3f g,
                                    Vec3f s, bool transmit, AllowedEvents allowed) {
  const float cos_g = dot(n, g);
  const float cos_s = transmit ? -dot(n, s) : dot(n, s);
  if (!(cos_g > 0.0f && cos_s > 0.0f)) {
    return {};
  }
  Vec3f h = transmit ? g + s * eta : g + s;
  const float length2 = length_squared(h);
  if (!(length2 > 0.0f)) {
    return {};
  }
  h *= 1.0f / std::sqrt(length2);
  if (dot(h, n) < 0.0f) {
    h = -h;
  }
  const float g_h = dot(g, h), s_h = dot(s, h);
  if (!(g_h > 0.0f) || (transmit ? !(s_h < 0.0f) : !(s_h > 0.0f))) {
    return {};  // the back of a facet, or directions that no facet refracts into each other
  }
  const FresnelSplit fresnel = lobe_fresnel(lobe, g_h, eta, film_ior);
  const float z2 = square(dot(h, n));
  float slopes, stretched_g, stretched_s;
  const float alpha_product = lobe.alpha_x * lobe.alpha_y;
  if (lobe.alpha_x == lobe.alpha_y) {
    // From the cross product: 1 - z2 has no digits left for smooth surfaces.
    slopes = length_squared(cross(n, h)) / alpha_product;
    stretched_g = alpha_product * std::max(1.0f - square(cos_g), 0.0f);
    stretched_s = alpha_product * std::max(1.0f - square(cos_s), 0.0f);
  } else {
    const Frame frame(n, lobe.tangent);
    const Vec3f lh = frame.to_local(h);
    slopes = square(lh.x / lobe.alpha_x) + square(lh.y / lobe.alpha_y);
    stretched_g = stretched(lobe.alpha_x, lobe.alpha_y, frame.to_local(g));
    stretched_s = stretched(lobe.alpha_x, lobe.alpha_y, frame.to_local(s));
  }
  float density, m_g, m_s;
  if (lobe.beckmann) {
    density = beckmann_density(alpha_product, slopes, z2);
    m_g = beckmann_masking(stretched_g, cos_g);
    m_s = beckmann_masking(stretched_s, cos_s);
  } else {
    density = ggx_density(alpha_product, slopes, z2);
    m_g = ggx_masking(stretched_g, cos_g);
    m_s = ggx_masking(stretched_s, cos_s);
  }
  const AllowedEvents events = facet_events(lobe, allowed);
  const float reflect = reflect_probability(fresnel, events.reflection, events.transmission);
  // |dh/ds|: 1 / (4 s.h) and eta^2 |s.h| / (g.h + eta s.h)^2.
  float jacobian = 0.25f, jacobian_g = 0.25f;  // times g.h (s.h), which visible normals cancel
  float probability = reflect;
  Color f = fresnel.r;
  if (transmit) {
    jacobian_g = g_h * -s_h / square(g_h + eta * s_h);
    jacobian = square(eta) * jacobian_g;
    probability = 1.0f - reflect;
    f = fresnel.t;
  }
  LobePair pair;
  pair.f = f * (density * jacobian / (cos_g + m_g + m_s * (cos_g / cos_s)));
  pair.pdf_s = probability * density * jacobian / (cos_g + m_g);
  pair.pdf_g = probability * density * jacobian_g / (cos_s + m_s);
  return pair;
}

// A facet's normal visible from v, in the frame's coordinates turned to the world.
inline Vec3f sample_facet(const Lobe& lobe, Vec3f n, Vec3f v, Vec2f u) {
  const Frame frame = lobe.alpha_x == lobe.alpha_y ? Frame(n) : Frame(n, lobe.tangent);
  const Vec3f local = frame.to_local(v);
  return frame.to_world(lobe.beckmann
                            ? sample_beckmann_visible(local, lobe.alpha_x, lobe.alpha_y, u)
                            : sample_ggx_visible(local, lobe.alpha_x, lobe.alpha_y, u));
}

// v refracted at a facet h (v.h > 0); the caller knows that there is no total reflection.
inline Vec3f refract(Vec3f v, Vec3f h, float eta) {
  const float c = dot(v, h);
  const float inv_eta = 1.0f / eta;
  const float cos_t = safe_sqrt(1.0f - square(inv_eta) * std::max(1.0f - c * c, 0.0f));
  return normalize(h * (inv_eta * c - cos_t) - v * inv_eta);
}

}  // namespace vernier
