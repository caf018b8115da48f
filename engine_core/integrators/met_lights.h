// The light that a camera's walk meets along one of its rays: what all tracers with such walks
// share.
#pragma once

#include "integrators/camera_film.h"
#include "lights/light_sampler.h"
#include "paths/random_walk.h"

namespace vernier {

// Calls add(LightHit, distance, beyond) for every lamp that `ray` crosses, `distance` from the last
// vertex that scattered, and where the ray leaves the scene (not `found`) for what lies beyond it.
// An open sky that the film shows as nothing takes its part of `film` instead. `from`: where the
// direction was sampled with a density, or null. Returns whether the walk goes on.
template <class Film, class Add>
bool meet_lights(const Scene& scene, const Receiver* from, const Walk& walk, const Ray& ray,
                 bool found, Film& film, const Add& add) {
  const LightSampler& lights = *scene.lights;
  if (lights.has_lamp_hits(walk.mask)) {
    lights.for_each_lamp_hit(from, ray, walk.mask, walk.travelled, [&](const LightHit& lamp) {
      add(lamp, walk.travelled + lamp.t, false);
    });
  }
  if (found) {
    return true;
  }
  if (walk.depth.total == 0 && scene.film.transparent) {
    film.uncover(walk.beta);
  } else if (lights.has_escapes(walk.mask)) {
    lights.for_each_escape(from, ray.d, walk.mask, walk.flags, walk.depth,
                           [&](const LightHit& light) { add(light, kInfinity, true); });
  }
  return false;
}

// The density, over solid angle at `from`, with which light sampling would have chosen what glows
// at `point`, which the walk has met; 0 where `from` is null.
inline float pdf_met_surface(const LightSampler& lights, const Receiver* from, const Walk& walk,
                             const SurfacePoint& point) {
  return from ? lights.pdf_triangle(*from, point.instance, point.triangle, -point.wo,
                                    walk.travelled, std::abs(dot(point.ng, point.wo)))
              : 0.0f;
}

}  // namespace vernier
