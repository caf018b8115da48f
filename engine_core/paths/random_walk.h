// The walk that carries every sub-path, from the camera and from lights alike.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <limits>
#include <optional>

#include "bsdf/bsdf.h"
#include "paths/bounce_kinds.h"
#include "paths/bounce_limits.h"
#include "paths/path_vertex.h"
#include "paths/roulette.h"
#include "paths/spawn.h"
#include "sampling/dimensions.h"
#include "sampling/sobol.h"
#include "scene/scene.h"

namespace vernier {

// Where a walk is: the ray it is about to trace, and what it carries along it.
struct Walk {
  Ray ray;
  Transport mode = Transport::kRadiance;
  Color beta = splat(1.0f);
  // Roulette's measure: the largest component of beta at the start, as it would be in the medium
  // where the walk is. (Importance is over the squared index, and so changes with it: that is no
  // loss.)
  float start = 1.0f;
  uint32_t flags = kRayCamera;
  uint32_t mask = kVisibleCamera;
  PathDepth depth;
  bool spent = false;      // from the camera: the limits leave nothing but to meet a light
  float travelled = 0.0f;  // from the last vertex that scattered, through transparent surfaces
  uint32_t index = 0;      // surfaces met, transparent ones included
  int most_bounces = std::numeric_limits<int>::max();  // of this walk; the limits hold besides

  // The numbers that belong to the current vertex, drawn together: all but kJoin.
  static constexpr uint32_t kDraws = static_cast<uint32_t>(BounceDim::kJoin);
  std::array<Vec2f, kDraws> draws;
  Vec2f draw(BounceDim d) const { return draws[static_cast<size_t>(d)]; }
};

// What walks share. A Sampler has get_2d() and get_2d_run() as SobolSampler has them.
template <class Sampler = SobolSampler>
struct WalkContext {
  const Scene& scene;
  const Sampler& sampler;
  const std::atomic<bool>& cancelled;
  BounceLimits limits;
  Roulette roulette;
  uint64_t& rays;
};

// Follows `walk` to its end. The visitor says what the path is for:
//   bool segment(const Walk&, const Ray& ray, bool found)  a ray, which ends at a surface where
//       `found`; false ends the walk there;
//   PathVertex& vertex()  where the next vertex is to be written;
//   bool arrive(const Walk&, PathVertex&)  a surface, its closures evaluated; false ends the walk;
//   void pass(const PathVertex&)  the walk goes straight on through the surface: no scattering;
//   void leave(const PathVertex&, const BsdfSample&)  the walk scatters and goes on;
//   uint8_t lobes(const PathVertex&)  optional, for walks from the camera: the lobes that it may go
//       on by.
template <class Sampler, class Visitor>
void random_walk(const WalkContext<Sampler>& context, Walk& walk, Visitor& visitor) {
  const Scene& scene = context.scene;
  const bool from_camera = walk.mode == Transport::kRadiance;
  for (;; ++walk.index) {
    if (context.cancelled.load(std::memory_order_relaxed)) {
      return;
    }
    Hit hit;
    ++context.rays;
    const bool found = scene.intersect(walk.ray, walk.mask, hit);
    if (found) {
      walk.ray.t_max = hit.t;
    }
    if (!visitor.segment(walk, walk.ray, found) || !found) {
      return;
    }
    PathVertex& v = visitor.vertex();
    v.point = scene.surface_point(walk.ray, hit);
    v.point.ray_flags = walk.flags;
    v.point.depth = walk.depth;
    walk.travelled += v.point.ray_length;
    evaluate_bsdf(scene, v.point, v.bsdf);
    v.beta = walk.beta;
    v.mode = walk.mode;
    v.traits = &scene.materials[v.point.material]->traits();
    walk.draws = context.sampler.template get_2d_run<Walk::kDraws>(
        from_camera ? dimension(walk.index, BounceDim{})
                    : light_dimension(walk.index, BounceDim{}));
    if (!visitor.arrive(walk, v)) {
      return;
    }
    const Vec2f u = walk.draw(BounceDim::kLobe);
    std::optional<BsdfSample> sample;
    if constexpr (requires { visitor.lobes(v); }) {
      // What the camera sees of closures that depend on the viewer is what is evaluated.
      sample =
          v.bsdf.sample_forward(u.x, walk.draw(BounceDim::kDirection), v.mode, visitor.lobes(v));
    } else {
      sample = scatter_sample(scene, v, u.x, walk.draw(BounceDim::kDirection));
    }
    if (!sample || is_black(sample->weight)) {
      return;
    }
    const bool straight = (sample->lobe & kLobeTransparent) != 0;
    if (walk.spent && !straight) {
      return;
    }
    if (from_camera || straight || !context.limits.kinds_from_lights) {
      scatter(sample->lobe, walk.depth, walk.flags, walk.mask);
    } else {
      scatter_from_light(scene, v, *sample, walk.draw(BounceDim::kLightChoice).y, walk.depth,
                         walk.flags, walk.mask);
      if (context.limits.spent(walk.depth)) {
        return;
      }
    }
    if (!context.limits.allow(walk.depth) || walk.depth.total > walk.most_bounces) {
      return;
    }
    walk.spent = from_camera && context.limits.spent(walk.depth);
    walk.beta *= sample->weight;
    if (!from_camera) {
      walk.start /= square(sample->eta);
    }
    const float survival = context.roulette.survival(walk.depth.total, walk.index,
                                                     max_component(walk.beta) / walk.start);
    if (!(u.y < survival)) {
      return;
    }
    if (survival < 1.0f) {
      walk.beta *= 1.0f / survival;
    }
    if (straight) {
      visitor.pass(v);
    } else {
      visitor.leave(v, *sample);
      walk.travelled = 0.0f;
    }
    walk.ray = spawn_ray(v.point, sample->wi);
  }
}

}  // namespace vernier
