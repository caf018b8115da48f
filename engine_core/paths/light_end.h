// The end of a path on a light: the densities with which each side makes it (see mis.h).
#pragma once

#include <algorithm>

#include "lights/light_sampler.h"
#include "paths/join_guide.h"
#include "paths/mis.h"
#include "paths/path_vertex.h"

namespace vernier {

// What these densities depend on besides the path.
struct LightEnds {
  const Scene& scene;
  const EmissionGuide& guide;
  MisHeuristic heuristic;
  double merge_area = 0;  // paths from lights times the area in which they are gathered; 0: none
  const JoinGuide* joins = nullptr;  // null: a sample joins the vertices of its own light path
  double own_paths = 1.0;            // how often a sample has one

  // How often such vertices are joined, for each path from the camera and each that is shared.
  double joins_of(Vec3f light, Vec3f camera) const {
    return joins != nullptr ? joins->joins(light, camera) : own_paths;
  }
};

// The vertex as lights are sampled for it.
inline Receiver receiver_of(const Scene& scene, const PathVertex& v) {
  return {v.point, (lobes_of_both_sides(scene, v.point, v.bsdf) & kLobeTransmission) != 0};
}

// Density of a ray from `light` that arrives at v from wi, over the area at v and the solid angle
// there; points: over the area alone.
inline double emission_density(const LightEnds& ends, uint32_t light, const PathVertex& v, Vec3f wi,
                               float distance) {
  const LightSampler& lights = *ends.scene.lights;
  const double density =
      static_cast<double>(lights.pdf_emission_ray(ends.guide, light, v.point.p, -wi)) *
      static_cast<double>(abs_cosine(v.point, wi));
  const double d2 = static_cast<double>(distance) * static_cast<double>(distance);
  return lights.is_point(light) ? density / std::max(d2, kLeastSquare) : density;
}

// The state of the first surface vertex of a path that started with e.
inline MisState first_from_light(const LightEnds& ends, const EmissionSample& e,
                                 const PathVertex& v, float distance) {
  const LightSampler& lights = *ends.scene.lights;
  const Receiver receiver = receiver_of(ends.scene, v);
  const float sampled =
      e.delta_position || e.delta_direction
          ? lights.pdf_selection(receiver, e.light)
          : lights.pdf_light(receiver, e.light, v.point.wo, e.infinite ? kInfinity : distance, e.n);
  MisState state;
  state.pdf = emission_density(ends, e.light, v, v.point.wo, distance);
  state.neighbour = ends.heuristic.joins() ? ends.heuristic(static_cast<double>(sampled)) : 0.0;
  state.chain = lights.is_hittable(e.light) ? 1.0 : 0.0;
  return state;
}

}  // namespace vernier
