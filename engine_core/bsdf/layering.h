// What lobes are from a direction: albedos, energy compensation, attenuation by layers above.
#pragma once

#include "bsdf/lobe.h"

namespace vernier {

// Weights are capped here, so that times the sharpest density (2e9) and Veach's factor (at most
// the inverse rounding of a cosine, 2e7) they stay finite.
inline constexpr float kMaxWeight = 1e20f;

struct SurfaceSide {
  Vec3f ng;    // on the direction's side
  Vec3f d;     // the direction
  float sign;  // +1: on the side of the stored lobes' normals
};

// Relative index beyond the surface and of the film, seen from a side.
inline float eta_from(const Lobe& lobe, float sign) {
  const bool refracts = lobe.kind == LobeKind::kGlass || lobe.kind == LobeKind::kRefraction;
  return sign < 0.0f && refracts ? 1.0f / lobe.eta : lobe.eta;
}
inline float film_ior_from(const Lobe& lobe, float sign) {
  return sign < 0.0f && lobe.kind == LobeKind::kGlass ? lobe.film.ior / lobe.eta : lobe.film.ior;
}

// The lobe's albedo within its scale, as Cycles estimates it: reflection and transmission.
struct LobeAlbedo {
  Color r, t;
};
LobeAlbedo lobe_albedo(const Lobe& lobe, float cos_v, float eta, float film_ior);

// The lobe from a side; `above` is the attenuation of the layers over it. `alone`: it is the only
// one, and always chosen. Otherwise if the lobe is a layer, `below` is set to the attenuation of
// what lies under it.
LobeSide see_lobe(const Lobe& lobe, Color above, const SurfaceSide& side, bool alone, Color& below);

}  // namespace vernier
