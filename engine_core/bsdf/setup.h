// Parts of setting up lobes that several closures share.
#pragma once

#include "bsdf/bsdf.h"
#include "bsdf/energy_tables.h"
#include "bsdf/fresnel.h"
#include "bsdf/microfacet.h"
#include "bsdf/oren_nayar.h"

namespace vernier {

// Diffuse roughness below which Cycles takes Lambert's law.
inline constexpr float kLambertRoughness = 1e-5f;
// Indices of refraction lie in [1/kMaxIor, kMaxIor]; the lower end is Cycles'.
inline constexpr float kMaxIor = 1e5f;
// Relative indices this near 1 bend nothing: the surface is a (nearly) invisible mirror, as Cycles
// treats its refraction.
inline constexpr float kMatchedIor = 1e-4f;

inline Color clamp01(Color c) { return min(max(c, Color{}), splat(1.0f)); }
inline float clamp_ior(float ior) { return clamp(ior, 1.0f / kMaxIor, kMaxIor); }

// The tangent turned about the normal by a number of full circles (Rodrigues' formula).
inline Vec3f rotated_tangent(Vec3f tangent, Vec3f normal, float turns) {
  if (turns == 0.0f) {
    return tangent;
  }
  const float c = std::cos(kTwoPi * turns), s = std::sin(kTwoPi * turns);
  return tangent * c + cross(normal, tangent) * s + normal * (dot(normal, tangent) * (1.0f - c));
}

// Anisotropy in [0, 1] as the Principled and Metallic nodes have it (Burley 2012).
inline void set_anisotropy(Lobe& lobe, float anisotropy, Vec3f tangent, Vec3f normal, float turns) {
  if (anisotropy > 0.0f && !is_black(tangent)) {
    const float aspect = std::sqrt(1.0f - 0.9f * anisotropy);
    lobe.alpha_x = lobe.alpha_x / aspect;
    lobe.alpha_y = lobe.alpha_y * aspect;
    lobe.tangent = rotated_tangent(tangent, normal, turns);
  }
}

inline void set_f82(Lobe& lobe, Color f0, Color tint) {
  lobe.fresnel = FresnelKind::kF82;
  lobe.f0 = f0;
  lobe.b = tint == splat(1.0f) ? Color{} : f82_b_from_tint(f0, tint);
}

// Glass of an index relative to the outside of the surface, with its true Fresnel curve.
inline void set_dielectric(Lobe& lobe, float ior, bool backfacing, ThinFilm film) {
  lobe.fresnel = FresnelKind::kSchlick;
  lobe.eta = backfacing ? 1.0f / ior : ior;
  lobe.film = {std::max(film.thickness, 0.0f), clamp_ior(film.ior)};
  if (backfacing) {
    lobe.film.ior *= lobe.eta;
  }
}

inline void set_mirrored(Lobe& lobe) {
  lobe.mirrored = true;
  lobe.transmission_bits =
      static_cast<uint8_t>((lobe.reflection_bits & ~kLobeReflection) | kLobeTransmission);
  lobe.reflection_bits = 0;
}

inline void set_oren_nayar(Lobe& lobe, float roughness, Color color) {
  lobe.kind = LobeKind::kOrenNayar;
  lobe.alpha_x = roughness;
  lobe.f0 = OrenNayar(roughness).multiple_scattering(color);
}

// Decides whether the lobe is singular, and prepares its energy compensation.
inline void finish_microfacet(Lobe& lobe, bool compensate, Color average_fresnel) {
  lobe.alpha_x = saturate(lobe.alpha_x);
  lobe.alpha_y = saturate(lobe.alpha_y);
  lobe.roughness = lobe.alpha_x == lobe.alpha_y ? std::sqrt(lobe.alpha_x)
                                                : std::sqrt(std::sqrt(lobe.alpha_x * lobe.alpha_y));
  lobe.ior_axis = ior_axis(lobe.eta);
  if (lobe.fresnel == FresnelKind::kSchlick || lobe.thin) {
    lobe.true_f0 = square(square(lobe.ior_axis));  // see f0_from_ior
    lobe.blend_scale = lobe.true_f0 < 1.0f ? 1.0f / (1.0f - lobe.true_f0) : 0.0f;
  }
  const bool refracts = lobe.kind != LobeKind::kReflection;
  if (lobe.alpha_x * lobe.alpha_y <= kSingularAlphaProduct ||
      (refracts && std::abs(lobe.eta - 1.0f) < kMatchedIor)) {
    lobe.singular = true;
    lobe.alpha_x = lobe.alpha_y = 0.0f;
    lobe.reflection_bits = lobe.reflection_bits ? lobe.reflection_bits | kLobeSingular : 0;
    lobe.transmission_bits = lobe.transmission_bits ? lobe.transmission_bits | kLobeSingular : 0;
    return;  // a mirror loses nothing
  }
  lobe.compensate = compensate;
  if (compensate) {
    lobe.average_fresnel = clamp01(average_fresnel);
    lobe.average_energy =
        lookup_1d<EnergyTables::kFine>(energy_tables.reflection_average.data(), lobe.roughness);
  }
}

}  // namespace vernier
