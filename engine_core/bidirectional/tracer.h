// The tracer of bidirectional paths.
//
// One sample is a light sub-path and a camera sub-path. The first splats every vertex to the camera
// (techniques with t = 1). The second meets lights (s = 0), samples lights (s = 1) and is joined to
// every vertex of the first, or to some of all that a batch shares (s, t >= 2), at each of its
// vertices. Where the method merges, it also gathers there what ends nearby of the first sub-paths
// of all samples of the batch (vertex connection and merging: Georgiev et al. 2012). The
// bookkeeping of the weights is paths/mis.h.
#pragma once

#include <cmath>

#include "bidirectional/light_vertices.h"
#include "bidirectional/plan.h"
#include "bidirectional/shared_paths.h"
#include "bidirectional/technique_set.h"
#include "integrators/camera_film.h"
#include "integrators/camera_loop.h"
#include "integrators/filtered_splats.h"
#include "integrators/met_lights.h"
#include "lights/light_sampler.h"
#include "paths/light_walk.h"
#include "paths/visibility.h"

namespace vernier {

template <BidirectionalFeatures F, class Observer = NoObserver, class Sampler = SobolSampler>
class BidirectionalTracer {
 public:
  using Passes = std::conditional_t<F.passes, PassSample, NoPassSample>;

  BidirectionalTracer(const RenderContext& context, const Sampler& sampler, RenderStats& stats,
                      SplatFrame* splats, Passes& passes, BidirectionalMemory& memory,
                      Observer& observer, const SharedPaths* shared = nullptr)
      : BidirectionalTracer(context, sampler, stats, splats, passes, memory, observer,
                            TechniqueSet(context.settings, context.scene.requirements), shared) {}
  BidirectionalTracer(const RenderContext& context, const Sampler& sampler, RenderStats& stats,
                      SplatFrame* splats, Passes& passes, BidirectionalMemory& memory,
                      Observer& observer, const TechniqueSet& techniques,
                      const SharedPaths* shared = nullptr)
      : scene_(context.scene),
        lights_(*context.scene.lights),
        camera_(*context.scene.camera),
        settings_(context.settings),
        plan_(static_cast<const BidirectionalPlan&>(*context.plan)),
        filter_(context.filter),
        techniques_(techniques),
        heuristic_(techniques_.heuristic(context.settings)),
        walks_{context.scene,
               sampler,
               context.cancelled,
               BounceLimits::of_both_sides(context.settings),
               Roulette(context.settings),
               stats.rays},
        stats_(stats),
        splats_(context.scene.film, context.filter, splats),
        shared_(shared),
        light_(memory.light),
        ends_(memory.ends),
        camera_path_(memory.camera),
        film_(context.scene, passes),
        passes_(passes),
        observer_(observer) {
    if constexpr (F.merging) {
      light_vertices_ = static_cast<const LightVertices*>(context.light_pass);
      merge_area_ = light_vertices_->area();
    }
    const FilmDesc& film = scene_.film;
    light_paths_ = static_cast<double>(film.crop[2] - film.crop[0]) *
                   static_cast<double>(film.crop[3] - film.crop[1]) * plan_.own_paths;
    light_share_ =
        light_paths_ / (static_cast<double>(film.width) * static_cast<double>(film.height));
  }

  CameraSample run(const CameraRay& camera_ray) {
    light_.clear();
    ends_.clear();
    camera_path_.clear();
    if (techniques_.light_paths && techniques_.joins && techniques_.most_light_bounces >= 0 &&
        has_own_path()) {
      const CountedRays counted(*this);
      LightClient client{*this};
      walk_from_light(light_ends(), walks_, light_, stats_.non_finite, client,
                      techniques_.most_light_bounces);
    }
    if (techniques_.most_camera_bounces < 0) {
      return {radiance_, film_.alpha()};
    }
    start_distance_ = camera_ray.start_distance;
    Walk walk;
    walk.ray = camera_ray.ray;
    walk.most_bounces = techniques_.most_camera_bounces;
    CameraVisitor visitor{*this};
    random_walk(walks_, walk, visitor);
    return {radiance_, film_.alpha()};
  }

 private:
  // ---- From the light.

  bool has_own_path() const {
    return !(plan_.own_paths < 1.0) ||
           static_cast<double>(walks_.sampler.get_2d(dimension(LightDim::kChoice)).y) <
               plan_.own_paths;
  }
  // Tells the observer, where it wants to know, how many rays the light's sub-path takes.
  struct CountedRays {
    BidirectionalTracer& tracer;
    const uint64_t before;

    explicit CountedRays(BidirectionalTracer& of) : tracer(of), before(of.walks_.rays) {}
    ~CountedRays() {
      if constexpr (requires { tracer.observer_.traced_light(uint64_t{}); }) {
        tracer.observer_.traced_light(tracer.walks_.rays - before);
      }
    }
  };

  struct LightClient {
    BidirectionalTracer& tracer;

    void emitted(const EmissionSample& e) {
      tracer.light_number_ = e.light;
      tracer.observer_.emitted(e);
    }
    void reached(const Walk& walk, const PathVertex& v) {
      if (tracer.shared_ == nullptr) {
        tracer.ends_.emplace_back(v, tracer.light_.size() - 1);
      }
      tracer.splat_vertex(walk, v);
    }
  };

  void splat_vertex(const Walk& walk, const PathVertex& v);

  // ---- From the camera.

  struct CameraVisitor {
    BidirectionalTracer& tracer;
    MisDeparture departure{};
    Receiver receiver{};
    uint32_t last = kNoIndex;  // the vertex that scattered last
    bool crosses = true;       // paths from lights may contain the segment that is being walked

    bool segment(const Walk& walk, const Ray& ray, bool found) {
      return tracer.meet_lights(walk, ray, found, *this);
    }
    PathVertex& vertex() { return tracer.camera_path_.append(); }
    bool arrive(const Walk& walk, PathVertex& v) { return tracer.arrive(walk, v, *this); }
    void pass(const PathVertex& v) {
      // What only the camera sees splats pass as well: it need not be reached.
      crosses = crosses && !tracer.scene_.materials[v.point.material]->traits().path_dependent;
      if (!v.bsdf.connectible()) {
        tracer.camera_path_.drop();
      }
    }
    void leave(const PathVertex& v, const BsdfSample& sample) {
      last = tracer.camera_path_.scatter();
      if constexpr (F.passes) {
        if (v.parent == kNoIndex) {
          tracer.passes_.first_bounce(v.bsdf, sample);
        }
      }
      departure = departure_of(tracer.heuristic_, v, sample);
      receiver = receiver_of(tracer.scene_, v);
      crosses = true;
    }
    // Where the direction was sampled with a density, or null.
    const Receiver* sampled_from(const Walk& walk) const {
      return walk.depth.total > 0 && !departure.singular ? &receiver : nullptr;
    }
  };

  // Lamps that the ray crosses, and where it leaves the scene what lies beyond: techniques (0, t).
  bool meet_lights(const Walk& walk, const Ray& ray, bool found, const CameraVisitor& visitor) {
    if (!techniques_.camera_paths && walk.depth.total > 0) {
      return false;
    }
    return vernier::meet_lights(scene_, visitor.sampled_from(walk), walk, ray, found, film_,
                                [&](const LightHit& light, float distance, bool beyond) {
                                  add_met(walk, visitor, light.light, -ray.d, distance, light.pdf,
                                          light.radiance, beyond);
                                });
  }

  // Light that the walk met, leaving along `direction`, which light sampling would have found with
  // density `sampled`. `light` is kNoIndex where no other technique knows it.
  void add_met(const Walk& walk, const CameraVisitor& visitor, uint32_t light, Vec3f direction,
               float distance, float sampled, Color radiance, bool environment) {
    if (!techniques_.show(0, walk.depth.total + 2)) {
      return;
    }
    double others = 0.0;
    const MisDeparture& d = visitor.departure;
    if (walk.depth.total > 0 && light != kNoIndex) {
      const double emitted = visitor.crosses
                                 ? static_cast<double>(lights_.pdf_emission_ray(
                                       plan_.guide, light, visitor.receiver.p, direction))
                                 : 0.0;
      others = (techniques_.joins ? heuristic_(static_cast<double>(sampled) / d.pdf) : 0.0) +
               bounded_product(heuristic_(emitted * d.cosine / d.pdf), d.sum);
    }
    const PathVertex* z = walk.depth.total > 0 ? &camera_path_[visitor.last] : nullptr;
    add({0, walk.depth.total + 2, light, nullptr, nullptr, z, -direction, distance, others,
         walk.beta * radiance},
        walk.depth.total <= 1,
        [&](auto& passes, Color c) { passes.add_met(walk.depth.total, environment, c); });
  }

  bool arrive(const Walk& walk, PathVertex& v, const CameraVisitor& visitor) {
    const double cosine = static_cast<double>(abs_cosine(v.point, v.point.wo));
    v.other_reaches =
        techniques_.light_paths && !v.traits->path_dependent &&
        (scene_.instances[v.point.instance].visibility & kVisibleScattered) == kVisibleScattered;
    if (walk.depth.total == 0) {
      const float distance = start_distance_ + walk.travelled;
      film_.surface(v.point, v.bsdf, v.beta, distance);
      v.mis.pdf =
          static_cast<double>(camera_.pdf_across(-dot(v.point.wo, camera_.axis()), distance)) *
          cosine / light_share_;
      v.mis.neighbour = visitor.crosses && techniques_.joins ? 1.0 : 0.0;
      v.mis.chain = 0.0;
    } else {
      v.mis = visitor.departure.arrive(heuristic_, static_cast<double>(walk.travelled), cosine,
                                       visitor.crosses,
                                       light_ends().joins_of(v.point.p, visitor.receiver.p));
    }
    if constexpr (F.merging) {
      allow_merges(heuristic_, merge_area_, v);
    }
    if (!is_black(v.bsdf.emission)) {
      add_emission(walk, visitor, v);
    }
    if (!techniques_.camera_paths) {
      return !is_black(v.bsdf.transparency);
    }
    if (v.bsdf.connectible() && walk.depth.total < walks_.limits.total && !walk.spent) {
      if constexpr (F.merging) {
        merge(walk, v);
      }
      if (!techniques_.joins) {
        return true;
      }
      sample_light(walk, v);
      connect_all(walk, v);
    }
    return true;
  }

  void add_emission(const Walk& walk, const CameraVisitor& visitor, const PathVertex& v) {
    const SurfacePoint& point = v.point;
    const float sampled = pdf_met_surface(lights_, visitor.sampled_from(walk), walk, point);
    add_met(walk, visitor, lights_.light_of_triangle(point.instance, point.triangle), point.wo,
            walk.travelled, sampled, v.bsdf.emission, false);
  }

  // Next-event estimation: technique (1, t).
  void sample_light(const Walk& walk, const PathVertex& v) {
    if (lights_.count() == 0 || !techniques_.show(1, walk.depth.total + 2)) {
      return;
    }
    const Vec2f choice = walk.draw(BounceDim::kLightChoice);
    LightSample light;
    if (!lights_.sample(receiver_of(scene_, v), choice.x, walk.draw(BounceDim::kLightPoint),
                        light)) {
      return;
    }
    const uint8_t mask = lobes_lit(light.visibility);
    const BsdfEval eval = scatter_eval(scene_, v, light.wi, mask);
    Color c = v.beta * eval.f * light.radiance * (1.0f / light.pdf);
    if (is_black(c)) {
      return;
    }
    const double pdf = static_cast<double>(light.pdf);
    const double met = light.hittable ? heuristic_(static_cast<double>(eval.pdf) / pdf) : 0.0;
    double emitted = 0.0;
    if (v.other_reaches) {
      emitted =
          v.mis.sum(heuristic_,
                    emission_density(light_ends(), light.light, v, light.wi, light.distance) / pdf,
                    static_cast<double>(eval.pdf_reverse));
    }
    if (!plan_.worthwhile(c, techniques_.weight(met + emitted), choice.y)) {
      return;
    }
    if (light.cast_shadow) {
      bool blocked = false;  // for paths from the light
      c *= transmittance<F.transparent>(segments(), spawn_shadow_ray(v.point, light), walk.depth,
                                        &blocked);
      if (is_black(c)) {
        return;
      }
      emitted = blocked ? 0.0 : emitted;
    }
    const double others = met + emitted;
    add_reaching(walk, mask, walk.depth.total == 0,
                 {1, walk.depth.total + 2, light.light, nullptr, nullptr, &v, light.wi,
                  light.distance, others, c});
  }

  void connect_all(const Walk& walk, const PathVertex& v);
  struct Join;
  bool choose_join(const Walk& walk, const PathVertex& v, Color brightness, const JoinEnd& y,
                   double joins, float u, Join& join) const;
  void connect(const Walk& walk, const PathVertex& v, const Join& join, float u);
  void merge(const Walk& walk, const PathVertex& v);
  void merge(const Walk& walk, const PathVertex& v, const LightVertex& y, Vec3f position,
             float density);

  // Light that reaches vertex z of the path from wi, through the lobes of `mask`.
  void add_reaching(const Walk& walk, uint8_t mask, bool direct, FoundPath&& path) {
    add(std::move(path), direct, [&](auto& passes, Color c) {
      if (walk.depth.total == 0) {
        passes.add_first_light(path.z->bsdf, path.wi, mask, c, direct);
      } else {
        passes.add_later_light(c);
      }
    });
  }

  LightEnds light_ends() const {
    return {scene_,
            plan_.guide,
            heuristic_,
            merge_area_,
            shared_ != nullptr ? &plan_.joins : nullptr,
            plan_.own_paths};
  }
  SegmentContext segments() const { return {scene_, walks_.limits.transparent, walks_.rays}; }

  Color clamp(Color c, bool direct) const {
    return clamp_sample(c, direct ? settings_.clamp_direct : settings_.clamp_indirect);
  }

  // Adds the path's light, not yet weighted, to the picture and where asked for to its passes.
  template <class ToPasses>
  void add(FoundPath&& path, bool direct, const ToPasses& to_passes) {
    path.contribution *= static_cast<float>(techniques_.weight(path.others));
    if (!is_finite(path.contribution)) {
      ++stats_.non_finite;
      return;
    }
    path.contribution = clamp(path.contribution, direct);
    observer_.found(path);
    radiance_ += path.contribution;
    if constexpr (F.passes) {
      to_passes(passes_, path.contribution);
    }
  }

  const Scene& scene_;
  const LightSampler& lights_;
  const Camera& camera_;
  const Settings& settings_;
  const BidirectionalPlan& plan_;
  const PixelFilter2d& filter_;
  const TechniqueSet techniques_;
  const MisHeuristic heuristic_;
  const WalkContext<Sampler> walks_;
  RenderStats& stats_;
  const FilteredSplats splats_;
  const SharedPaths* shared_;  // null: camera vertices are joined to the sample's own light path
  Subpath& light_;
  std::vector<JoinEnd>& ends_;
  Subpath& camera_path_;
  CameraFilm<F.passes> film_;
  std::conditional_t<F.passes, LightPasses, NoPasses> passes_;
  Observer& observer_;
  Color radiance_;
  uint32_t light_number_ = kNoIndex;  // of the light's sub-path
  float start_distance_ = 0.0f;
  double light_paths_;  // for each sample of all pixels that are rendered, in all of these
  double light_share_;  // over the samples of the full frame
  const LightVertices* light_vertices_ = nullptr;  // to be merged with
  double merge_area_ = 0.0;                        // LightVertices::area()
};

}  // namespace vernier

#include "bidirectional/joins.h"
