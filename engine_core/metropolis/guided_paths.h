// The technique that goes by a CausticGuide: what else is left to the BSDF's chance alone.
//
// It makes paths whose first surface from the camera is specular, whose rough surfaces have
// specular ones to either side, and whose last surfaces before the light are specular: no two
// neighbours can be joined, so that of the bidirectional techniques only (0, t) makes them. At the
// last rough surface the direction is drawn from the guide. The two share all other densities, and
// weigh by the ratio of these two alone.
#pragma once

#include "bidirectional/technique_set.h"
#include "integrators/camera_loop.h"
#include "integrators/met_lights.h"
#include "metropolis/caustic_guide.h"
#include "metropolis/primary_sample.h"
#include "paths/random_walk.h"

namespace vernier {

class GuidedPaths {
 public:
  // `guide` outlives this.
  GuidedPaths(const RenderContext& context, const CausticGuide& guide)
      : context_(context),
        guide_(guide),
        heuristic_(TechniqueSet(context.settings, context.scene.requirements)
                       .heuristic(context.settings)) {}

  // Whether there is anything to guide to.
  bool any() const { return !guide_.empty(); }

  // The part that a path which the camera's walk has found keeps beside the guide.
  float left(const Subpath& camera, const FoundPath& path) const;

  // Goes on from each vertex of a camera's path that suits. `length`: the number of vertices of
  // paths to make; -1: any. Calls found(const FoundPath&), as of technique (0, t); the vertices are
  // appended to `camera`.
  template <class Sampler, class Found>
  void make(Subpath& camera, const Sampler& sampler, RenderStats& stats, int length,
            const Found& found) const {
    const uint32_t count = camera.size();
    uint32_t number = 0;
    for (uint32_t i = 0; i < count; ++i) {
      if (suits(camera, i)) {
        go_on(camera, i, number++, sampler, stats, length, found);
      }
    }
  }

 private:
  // Surfaces between the guided one and the light, at most.
  static constexpr int kMostSpecular = 16;

  static bool specular(const PathVertex& v) { return !v.bsdf.connectible(); }
  static bool rough(const PathVertex& v) {
    return v.bsdf.connectible() && (v.bsdf.lobes() & kLobeSingular) == 0;
  }

  // Whether the vertex is rough and comes after specular ones, between which all others are rough.
  static bool suits(const Subpath& camera, uint32_t at);

  // Numbers of one vertex's walk, apart from all others.
  template <class Sampler>
  struct Numbers {
    const Sampler& sampler;
    uint32_t first;
    template <uint32_t kCount>
    std::array<Vec2f, kCount> get_2d_run(uint32_t dimension) const {
      return sampler.template get_2d_run<kCount>(first + dimension);
    }
  };

  template <class Found>
  struct Visitor {
    const GuidedPaths& paths;
    Subpath& camera;
    RenderStats& stats;
    int length;
    double others;  // the BSDF's density over the guide's
    uint32_t last;  // the vertex that scattered last
    const Found& found;
    int surfaces = 0;  // specular ones so far
    bool ended = false;

    bool segment(const Walk& walk, const Ray& ray, bool hit) {
      if (ended) {
        return false;
      }
      if (surfaces == 0) {
        return true;
      }
      NoPassSample none;
      CameraFilm<false> film(paths.context_.scene, none);
      return meet_lights(paths.context_.scene, nullptr, walk, ray, hit, film,
                         [&](const LightHit& light, float distance, bool) {
                           add(walk, light.light, ray.d, distance, light.radiance);
                         });
    }
    PathVertex& vertex() {
      PathVertex& v = camera.append();
      v.parent = last;
      return v;
    }
    bool arrive(const Walk& walk, const PathVertex& v) {
      if (surfaces > 0 && !is_black(v.bsdf.emission)) {
        add(walk,
            paths.context_.scene.lights->light_of_triangle(v.point.instance, v.point.triangle),
            -v.point.wo, walk.travelled, v.bsdf.emission);
      }
      return specular(v) || !is_black(v.bsdf.transparency);
    }
    void pass(const PathVertex& v) {
      if (specular(v)) {
        camera.drop();
      }
    }
    void leave(const PathVertex& v, const BsdfSample&) {
      last = camera.scatter();
      ended = !specular(v) || ++surfaces > kMostSpecular;
    }

    void add(const Walk& walk, uint32_t light, Vec3f wi, float distance, Color radiance) {
      const int t = walk.depth.total + 2;
      if (length >= 0 && t != length) {
        return;
      }
      Color c = walk.beta * radiance * static_cast<float>(1.0 / (1.0 + others));
      if (!is_finite(c)) {
        ++stats.non_finite;
        return;
      }
      c = clamp_sample(c, paths.context_.settings.clamp_indirect);
      found(FoundPath{0, t, light, nullptr, nullptr, &camera[last], wi, distance, others, c});
    }
  };

  template <class Sampler, class Found>
  void go_on(Subpath& camera, uint32_t from, uint32_t number, const Sampler& sampler,
             RenderStats& stats, int length, const Found& found) const {
    // Each owns the numbers of so many surfaces, those that let light straight through included.
    constexpr uint32_t kOwned = dimension(1024, BounceDim{});
    const PathVertex& v = camera[from];
    const int before = v.point.depth.total + 2;  // vertices up to here
    if (length >= 0 && (length < before + 2 || length > before + 1 + kMostSpecular)) {
      return;
    }
    const DirectionLobes lobes = guide_.at(v.point);
    if (lobes.empty()) {
      return;
    }
    const uint32_t first = kFirstGuideDimension + number * kOwned;
    const auto u = sampler.template get_2d_run<2>(first);
    const Vec3f wi = lobes.sample(u[0].x, u[1]);
    const BsdfEval eval = scatter_eval(context_.scene, v, wi);
    const double pdf = lobes.pdf(wi);
    Walk walk;
    walk.beta = v.beta * eval.f * static_cast<float>(1.0 / pdf);
    if (is_black(walk.beta) || !(pdf > 0.0)) {
      return;
    }
    walk.start = max_component(walk.beta);
    walk.depth = v.point.depth;
    scatter(kLobeDiffuse | kLobeReflection, walk.depth, walk.flags, walk.mask);
    const WalkContext<Numbers<Sampler>> walks{context_.scene,
                                              Numbers<Sampler>{sampler, first},
                                              context_.cancelled,
                                              BounceLimits(context_.settings),
                                              Roulette(context_.settings, 0.0f, 0),
                                              stats.rays};
    if (!walks.limits.allow(walk.depth)) {
      return;
    }
    walk.most_bounces = length >= 0 ? length - 2 : walk.most_bounces;
    walk.ray = spawn_ray(v.point, wi);
    Visitor<Found> visitor{
        *this, camera, stats, length, heuristic_(static_cast<double>(eval.pdf) / pdf), from, found};
    random_walk(walks, walk, visitor);
  }

  const RenderContext& context_;
  const CausticGuide& guide_;
  const MisHeuristic heuristic_;
};

}  // namespace vernier
