#include "integrators/whitted.h"

#include <array>

#include "bsdf/bsdf.h"
#include "integrators/camera_loop.h"
#include "lights/light_sampler.h"
#include "nodes/material.h"
#include "paths/bounce_limits.h"
#include "paths/spawn.h"
#include "paths/visibility.h"

namespace vernier {
namespace {

// What the recursion hands down.
struct RayState {
  Ray ray;
  PathDepth depth;
  uint32_t flags = kRayCamera;
  uint32_t mask = kVisibleCamera;
};

class WhittedTracer {
 public:
  WhittedTracer(const RenderContext& context, RenderStats& stats)
      : scene_(context.scene),
        lights_(*context.scene.lights),
        depth_limit_(context.settings.whitted_depth),
        cancelled_(context.cancelled),
        stats_(stats) {}

  CameraSample run(const CameraRay& camera_ray) {
    RayState state;
    state.ray = camera_ray.ray;
    CameraSample sample;
    sample.radiance = radiance(state, 0, &sample.alpha);
    return sample;
  }

 private:
  // Radiance along a ray. `alpha`: of the film, while only transparent surfaces were passed.
  Color radiance(const RayState& state, int level, float* alpha) {
    Hit hit;
    ++stats_.rays;
    Color result;
    Ray ray = state.ray;
    const bool found = scene_.intersect(ray, state.mask, hit);
    if (found) {
      ray.t_max = hit.t;
    }
    if (lights_.has_lamp_hits(state.mask)) {
      lights_.for_each_lamp_hit(nullptr, ray, state.mask, 0.0f,
                                [&](const LightHit& lamp) { result += lamp.radiance; });
    }
    if (!found) {
      if (alpha != nullptr && scene_.film.transparent) {
        *alpha = 0.0f;
        return {};
      }
      lights_.for_each_escape(nullptr, ray.d, state.mask, state.flags, state.depth,
                              [&](const LightHit& light) { result += light.radiance; });
      return result;
    }
    SurfacePoint point = scene_.surface_point(ray, hit);
    point.ray_flags = state.flags;
    point.depth = state.depth;
    Bsdf bsdf;
    bsdf.begin(point);
    scene_.materials[point.material]->evaluate(point, bsdf);
    bsdf.finish();
    result += bsdf.emission;
    result += lamps(point, bsdf, state.depth);
    // Reflection and refraction double the rays at every level: one sample may take hours.
    if (level < depth_limit_ && !cancelled_.load(std::memory_order_relaxed)) {
      result += specular(point, bsdf, state, level, alpha);
    }
    return result;
  }

  // Every lamp's middle, or the middle of its shape where it has one.
  Color lamps(const SurfacePoint& point, const Bsdf& bsdf, const PathDepth& depth) {
    Color result;
    if (!bsdf.connectible()) {
      return result;
    }
    const Receiver from(point, (bsdf.lobes() & kLobeTransmission) != 0);
    for (uint32_t i = 0; i < lights_.count(); ++i) {
      LightSample light;
      if (!lights_.sample_light(from, i, {0.5f, 0.5f}, light)) {
        continue;
      }
      const BsdfEval eval =
          bsdf.eval_forward(light.wi, Transport::kRadiance, lobes_lit(light.visibility));
      Color c = eval.f * light.radiance * (1.0f / light.pdf);
      if (!is_black(c) && light.cast_shadow) {
        c *= transmittance<true>({scene_, depth_limit_, stats_.rays},
                                 spawn_shadow_ray(point, light), depth);
      }
      result += c;
    }
    return result;
  }

  Color specular(const SurfacePoint& point, const Bsdf& bsdf, const RayState& state, int level,
                 float* alpha) {
    std::array<BsdfSample, Bsdf::kMaxSingularEvents> events;
    const int count = bsdf.singular_events(events);
    Color result;
    for (int i = 0; i < count; ++i) {
      const BsdfSample& event = events[static_cast<size_t>(i)];
      RayState next = state;
      scatter(event.lobe, next.depth, next.flags, next.mask);
      next.ray = spawn_ray(point, event.wi);
      const bool straight = (event.lobe & kLobeTransparent) != 0;
      float beyond = 1.0f;
      result += event.weight * radiance(next, level + 1, straight && alpha ? &beyond : nullptr);
      if (straight && alpha != nullptr) {
        *alpha = 1.0f - average(event.weight) * (1.0f - beyond);
      }
    }
    return result;
  }

  const Scene& scene_;
  const LightSampler& lights_;
  const int depth_limit_;
  const std::atomic<bool>& cancelled_;
  RenderStats& stats_;
};

void render_whitted_tile(const RenderContext& context, const Batch& batch, const Tile& tile,
                         TileBuffer& buffer, PassSet /*passes*/, RenderStats& stats) {
  render_camera_tile<false>(context, batch, tile, buffer, stats,
                            [&](const CameraRay& ray, const SobolSampler&, NoPassSample&) {
                              return WhittedTracer(context, stats).run(ray);
                            });
}

}  // namespace

RenderTile whitted_kernel() { return render_whitted_tile; }

}  // namespace vernier
