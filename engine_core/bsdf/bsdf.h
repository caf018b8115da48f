// The scattering of light at one surface point: a weighted sum of lobes, plus emission.
//
// Conventions. `wo` is the given direction, `wi` the sampled one; both are unit, in render space,
// and point away from the surface. With Transport::kRadiance the path comes from the camera and wo
// is the camera's side; with kImportance it comes from a light and wi is the camera's side.
//
// Layering (coat, sheen, specular over diffuse) attenuates by the albedo that the *camera's* side
// sees, as Cycles does, so the sum is not reciprocal. eval() honours that in both modes: the same
// pair of directions gives the same f whichever end was sampled. Densities always depend on the
// given direction alone.
//
// A lobe implements the plain function. What makes transport non-symmetric is applied here, once:
// the squared relative index at refraction (radiance shrinks by eta^2 where importance does not)
// and Veach's shading-normal factor |wi.ns wo.ng| / |wi.ng wo.ns| for importance (Veach 1997,
// sections 5.2 and 5.3).
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "math/frame.h"
#include "math/vec.h"
#include "scene/surface_point.h"

namespace vernier {

enum class Transport : uint8_t { kRadiance, kImportance };

// What a lobe is. Also the mask by which passes and bounce limits select.
enum LobeBits : uint8_t {
  kLobeDiffuse = 1u << 0,
  kLobeGlossy = 1u << 1,
  kLobeReflection = 1u << 2,
  kLobeTransmission = 1u << 3,  // to the other side of the surface
  kLobeSingular = 1u << 4,      // a delta distribution: never part of eval()
  kLobeTransparent = 1u << 5,   // straight through, undeviated (with kLobeSingular)
  kLobeAny = 0xff,
};

// f includes |cos(wi, ns)| and all adjoint factors. Densities are per solid angle.
struct BsdfEval {
  Color f;
  float pdf = 0;          // of sampling wi given wo
  float pdf_reverse = 0;  // of sampling wo given wi, by a path of the other transport mode
};

struct BsdfSample {
  Vec3f wi;
  Color weight;           // f / pdf, over all lobes (singular: the sampled lobe's ratio)
  float pdf = 0;          // solid angle; singular: the probability of the choice of the lobe
  float pdf_reverse = 0;
  float eta = 1;          // index of the side wi is on over that of wo's side
  uint8_t lobe = 0;       // LobeBits of the sampled lobe
};

// A contract, to be completed by bsdf/: see notes. Lobe storage, adders for material programs.
class Bsdf;

}  // namespace vernier
