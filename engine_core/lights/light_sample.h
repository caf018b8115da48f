// The records that pass between lights and integrators.
#pragma once

#include <cstdint>

#include "math/vec.h"
#include "scene/surface_point.h"

namespace vernier {

// Where light is received: what the choice of a light, and the sampling of it, depend on. Keep it
// with a path's vertex: densities of what that vertex could have sampled need the same bits again.
struct Receiver {
  Vec3f p;                 // render space
  Vec3f ng, ns;            // unit geometric and shading normals, both on the side of wo
  bool transmits = false;  // some lobe carries light to the other side
  // Directions that the BSDF draws find the world as well, and the two are weighted against each
  // other: what is dim in it need not be sampled as a light.
  bool complemented = false;
  // What is scattered there goes to few directions. With `complemented`: a sample of a plain world
  // would be lost.
  bool narrow = false;

  Receiver() = default;
  Receiver(Vec3f p_, Vec3f ng_, Vec3f ns_, bool transmits_)
      : p(p_), ng(ng_), ns(ns_), transmits(transmits_) {}
  Receiver(const SurfacePoint& point, bool transmits_)
      : p(point.p), ng(point.ng), ns(point.ns), transmits(transmits_) {}
};

// A light as a receiver sampled it. The estimator is f * radiance / pdf, before visibility.
struct LightSample {
  Vec3f wi;                 // unit, from the receiver to the light
  float distance = 0;       // infinite for suns and the environment
  Color radiance;           // toward the receiver; delta lights: what arrives, without density
  float pdf = 0;            // solid angle, selection included; delta lights: the selection alone
  float pdf_selection = 0;  // probability of the choice of this light
  Vec3f p, p_error;         // the point on the light, and the bound of its rounding (finite ones)
  Vec3f n;                  // unit normal of the light there, on the receiver's side
  uint32_t light = kNoIndex;
  uint32_t instance = kNoIndex, triangle = kNoIndex;  // of emissive triangles
  uint32_t visibility = 0;  // Visibility bits: which lobes of the receiver it lights
  bool delta = false;       // a direction that no other technique finds
  bool hittable = false;    // scattered rays find it too; else its MIS weight is 1
  bool cast_shadow = true;  // false: nothing is in the way
};

// A light that a ray met: a lamp of finite size that the segment crosses (lamps do not block
// rays), or a sun or the environment that an escaping ray ends in.
struct LightHit {
  uint32_t light = kNoIndex;
  float t = 0;     // along the ray; infinite for suns and the environment
  Color radiance;  // toward the ray's origin
  float pdf = 0;   // solid-angle density of sample() from the receiver, selection
                   // included; 0 without a receiver
};

// Light as it leaves a light. The estimator of flux is
// radiance * cosine / (pdf_position * pdf_direction * pdf_selection).
//
// Where the direction is drawn before the position (spots, soft lamps, suns, the environment) only
// the product of the two densities is a density; the split is such that the reciprocal of each is
// of the size of what it measures.
struct EmissionSample {
  Vec3f p, p_error;         // origin; suns and the environment: on the disk before the scene
  Vec3f direction;          // unit, away from the light
  Vec3f n;                  // unit normal of the light at p; lights without one: the direction
  float cosine = 1;         // dot(n, direction) >= 0
  Color radiance;           // delta_position: intensity; delta_direction: irradiance across it
  float pdf_position = 0;   // area; 1 for delta_position
  float pdf_direction = 0;  // solid angle; 1 for delta_direction
  float pdf_selection = 0;
  // A soft lamp faces whatever it lights, so a line through it lights only what is farther than
  // this from p. What is hit nearer stays dark and ends the ray.
  float lit_from = 0;
  // What is lit at distance t from p is lit from the lamp's disk, which is this over t before p.
  float behind = 0;
  uint32_t light = kNoIndex;
  uint32_t instance = kNoIndex, triangle = kNoIndex;  // of emissive triangles
  uint32_t visibility = 0;                            // Visibility bits
  bool delta_position = false, delta_direction = false;
  bool infinite = false;  // a sun or the environment
  bool cast_shadow = true;
};

// The densities of an EmissionSample, without the selection.
struct EmissionPdf {
  float position = 0, direction = 0;
};

}  // namespace vernier
