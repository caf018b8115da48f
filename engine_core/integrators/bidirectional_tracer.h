// The tracer of bidirectional paths.
//
// One sample is a light sub-path and a camera sub-path. The first splats every vertex to the camera
// (techniques with t = 1). The second meets lights (s = 0), samples lights (s = 1) and is joined to
// every vertex of the first (s, t >= 2), at each of its vertices. The bookkeeping of the weights is
// paths/mis.h.
#pragma once

#include <cmath>

#include "integrators/bidirectional_plan.h"
#include "integrators/camera_film.h"
#include "integrators/camera_loop.h"
#include "integrators/filtered_splats.h"
#include "integrators/technique_set.h"
#include "lights/light_sampler.h"
#include "paths/light_end.h"
#include "paths/random_walk.h"
#include "paths/subpath.h"
#include "paths/visibility.h"

namespace vernier {

template <BidirectionalFeatures F, class Observer = NoObserver>
class BidirectionalTracer {
 public:
  using Passes = std::conditional_t<F.passes, PassSample, NoPassSample>;

  BidirectionalTracer(const RenderContext& context, const SobolSampler& sampler, RenderStats& stats,
                      SplatFrame* splats, Passes& passes, BidirectionalMemory& memory,
                      Observer& observer)
      : scene_(context.scene),
        lights_(*context.scene.lights),
        camera_(*context.scene.camera),
        settings_(context.settings),
        plan_(static_cast<const BidirectionalPlan&>(*context.plan)),
        filter_(context.filter),
        techniques_(context.settings, context.scene.requirements),
        heuristic_(static_cast<MisExponent>(context.settings.mis_heuristic) == MisExponent::kPower),
        walks_{context.scene,
               sampler,
               context.cancelled,
               BounceLimits(context.settings),
               Roulette(context.settings),
               stats.rays},
        stats_(stats),
        splats_(context.scene.film, context.filter, splats),
        light_(memory.light),
        camera_path_(memory.camera),
        film_(context.scene, passes),
        passes_(passes),
        observer_(observer) {
    const FilmDesc& film = scene_.film;
    light_paths_ = static_cast<double>(film.crop[2] - film.crop[0]) *
                   static_cast<double>(film.crop[3] - film.crop[1]);
    light_share_ =
        light_paths_ / (static_cast<double>(film.width) * static_cast<double>(film.height));
  }

  CameraSample run(const CameraRay& camera_ray) {
    light_.clear();
    camera_path_.clear();
    if (techniques_.light_paths) {
      trace_light();
    }
    start_distance_ = camera_ray.start_distance;
    Walk walk;
    walk.ray = camera_ray.ray;
    CameraVisitor visitor{*this};
    random_walk(walks_, walk, visitor);
    return {radiance_, film_.alpha()};
  }

 private:
  // ---- From the light.

  void trace_light() {
    const SobolSampler& sampler = walks_.sampler;
    EmissionSample e;
    if (!lights_.sample_emission(plan_.guide, sampler.get_2d(dimension(LightDim::kChoice)).x,
                                 sampler.get_2d(dimension(LightDim::kPosition)),
                                 sampler.get_2d(dimension(LightDim::kDirection)), e)) {
      return;
    }
    Walk walk;
    walk.ray = {e.infinite ? e.p : offset_origin(e.p, e.p_error, e.n, e.direction), e.direction,
                kInfinity};
    walk.mode = Transport::kImportance;
    walk.beta = e.radiance * (e.cosine / (e.pdf_position * e.pdf_direction * e.pdf_selection));
    if (!is_finite(walk.beta)) {
      ++stats_.non_finite;
      return;
    }
    walk.start = max_component(walk.beta);
    walk.flags = 0;
    walk.mask = kVisibleDiffuse;  // evenly visible scenes: all kinds of scattered rays are alike
    light_number_ = e.light;
    observer_.emitted(e);
    LightVisitor visitor{*this, e};
    random_walk(walks_, walk, visitor);
  }

  struct LightVisitor {
    BidirectionalTracer& tracer;
    const EmissionSample& emission;
    MisDeparture departure{};

    bool segment(const Walk&, const Ray&, bool) { return true; }
    PathVertex& vertex() { return tracer.light_.append(); }

    bool arrive(const Walk& walk, PathVertex& v) {
      if (v.traits->path_dependent) {
        tracer.light_.drop();
        return false;  // what it does to light depends on the camera's part of the path
      }
      if (walk.depth.total > 0) {
        v.mis = departure.arrive(tracer.heuristic_, static_cast<double>(walk.travelled),
                                 static_cast<double>(abs_cosine(v.point, v.point.wo)), true);
      } else if (walk.travelled > emission.lit_from) {
        v.mis = first_from_light(tracer.light_ends(), emission, v, walk.travelled);
      } else {
        tracer.light_.drop();
        return false;
      }
      if (v.bsdf.connectible()) {
        tracer.splat_vertex(walk, v);
      }
      return true;
    }

    void pass(const PathVertex& v) {
      if (!v.bsdf.connectible()) {
        tracer.light_.drop();
      }
    }
    void leave(const PathVertex& v, const BsdfSample& sample) {
      tracer.light_.scatter();
      departure = tracer.depart(v, sample);
    }
  };

  MisDeparture depart(const PathVertex& v, const BsdfSample& sample) const {
    return {heuristic_,
            v.mis,
            static_cast<double>(sample.pdf),
            static_cast<double>(sample.pdf_reverse),
            static_cast<double>(abs_cosine(v.point, sample.wi)),
            (sample.lobe & kLobeSingular) != 0,
            v.other_reaches};
  }

  Receiver receiver_at(const PathVertex& v) const { return receiver_of(scene_, v); }

  // Joins a light vertex to the camera: technique (s, 1).
  void splat_vertex(const Walk& walk, const PathVertex& v) {
    const int s = walk.depth.total + 2;
    if (!techniques_.show(s, 1) || walk.depth.total >= walks_.limits.total ||
        (scene_.instances[v.point.instance].visibility & kVisibleCamera) == 0) {
      return;
    }
    const Vec2f u_lens = camera_.is_pinhole() ? Vec2f{} : walk.draw(BounceDim::kLightPoint);
    const auto c = camera_.connect(v.point.p, u_lens, filter_.radius());
    if (!c) {
      return;
    }
    const BsdfEval eval = scatter_eval(scene_, v, c->wi);
    Color flux = v.beta * eval.f * c->importance;
    if (is_black(flux)) {
      return;
    }
    const float cos_lens = -dot(c->wi, camera_.axis());
    const double camera_pdf = static_cast<double>(camera_.pdf_across(cos_lens, c->distance)) *
                              static_cast<double>(abs_cosine(v.point, c->wi)) / light_share_;
    const double others = v.mis.sum(heuristic_, camera_pdf, static_cast<double>(eval.pdf_reverse));
    flux *= static_cast<float>(techniques_.weight(others) / light_paths_);
    // A splat of all paths is a pixel's value as often as there are pixels.
    const float u = walk.draw(BounceDim::kLightChoice).x;
    if (!plan_.worthwhile(flux, 1.0, u)) {
      return;
    }
    bool blocked = false;
    flux *= camera_transmittance<F.transparent>(
        segments(), spawn_segment(c->p_lens - c->wi * c->clip_begin, v.point), &blocked);
    if (blocked || is_black(flux)) {
      return;
    }
    if (!is_finite(flux)) {
      ++stats_.non_finite;
      return;
    }
    flux = clamp(flux, walk.depth.total == 0);
    observer_.found({s, 1, light_number_, &v, nullptr, c->wi, c->distance, others, flux});
    if constexpr (F.passes) {
      splats_.add(c->raster, flux, shares_toward_camera(scene_, v, c->wi), walk.depth.total == 0);
    } else {
      splats_.add(c->raster, flux);
    }
  }

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
      departure = tracer.depart(v, sample);
      receiver = tracer.receiver_at(v);
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
    const Receiver* from = visitor.sampled_from(walk);
    if (lights_.has_lamp_hits(walk.mask)) {
      lights_.for_each_lamp_hit(from, ray, walk.mask, walk.travelled, [&](const LightHit& lamp) {
        add_met(walk, visitor, lamp.light, -ray.d, walk.travelled + lamp.t, lamp.pdf, lamp.radiance,
                false);
      });
    }
    if (found) {
      return true;
    }
    if (walk.depth.total == 0 && scene_.film.transparent) {
      film_.uncover(walk.beta);
    } else if (lights_.has_escapes(walk.mask)) {
      lights_.for_each_escape(
          from, ray.d, walk.mask, walk.flags, walk.depth, [&](const LightHit& light) {
            add_met(walk, visitor, light.light, -ray.d, kInfinity, light.pdf, light.radiance, true);
          });
    }
    return false;
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
      others = heuristic_(static_cast<double>(sampled) / d.pdf) +
               bounded_product(heuristic_(emitted * d.cosine / d.pdf), d.sum);
    }
    const PathVertex* z = walk.depth.total > 0 ? &camera_path_[visitor.last] : nullptr;
    add({0, walk.depth.total + 2, light, nullptr, z, -direction, distance, others,
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
      v.mis.neighbour = visitor.crosses ? 1.0 : 0.0;
      v.mis.chain = 0.0;
    } else {
      v.mis = visitor.departure.arrive(heuristic_, static_cast<double>(walk.travelled), cosine,
                                       visitor.crosses);
    }
    if (!is_black(v.bsdf.emission)) {
      add_emission(walk, visitor, v);
    }
    if (!techniques_.camera_paths) {
      return !is_black(v.bsdf.transparency);
    }
    if (v.bsdf.connectible() && walk.depth.total < walks_.limits.total && !walk.spent) {
      sample_light(walk, v);
      const Vec2f u = walks_.sampler.get_2d(dimension(walk.index, BounceDim::kJoin));
      for (uint32_t i = 0; i < light_.size(); ++i) {
        if (light_[i].bsdf.connectible()) {
          connect(walk, v, light_[i], {rotate(u.x, i), rotate(u.y, i)});
        }
      }
    }
    return true;
  }

  void add_emission(const Walk& walk, const CameraVisitor& visitor, const PathVertex& v) {
    const SurfacePoint& point = v.point;
    const Receiver* from = visitor.sampled_from(walk);
    const float sampled =
        from ? lights_.pdf_triangle(*from, point.instance, point.triangle, -point.wo,
                                    walk.travelled, std::abs(dot(point.ng, point.wo)))
             : 0.0f;
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
    if (!lights_.sample(receiver_at(v), choice.x, walk.draw(BounceDim::kLightPoint), light)) {
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
    add_reaching(
        walk, mask, walk.depth.total == 0,
        {1, walk.depth.total + 2, light.light, nullptr, &v, light.wi, light.distance, others, c});
  }

  // Joins the two sub-paths: technique (s, t) with both at least 2.
  void connect(const Walk& walk, const PathVertex& v, const PathVertex& y, Vec2f u) {
    const int s = y.point.depth.total + 2;
    if (!techniques_.show(s, walk.depth.total + 2) ||
        !walks_.limits.allow_joined(walk.depth, y.point.depth)) {
      return;
    }
    const Vec3f d = y.point.p - v.point.p;
    const float d2 = length_squared(d);
    if (!(d2 > 0.0f)) {
      return;
    }
    const float distance = std::sqrt(d2);
    const Vec3f wi = d * (1.0f / distance);
    // As if both surfaces were matte or, the glossier they are, brighter: what is then far from
    // worthwhile is let go unseen.
    Color c =
        v.beta * y.beta *
        (abs_cosine(v.point, wi) * abs_cosine(y.point, wi) * brightness(v) * brightness(y) / d2);
    const float guess = max_component(c);
    if (!plan_.worthwhile(c, 1.0, u.x)) {
      return;
    }
    const float raised = max_component(c) / guess;
    const BsdfEval at_v = scatter_eval(scene_, v, wi);
    if (is_black(at_v.f)) {
      return;
    }
    const BsdfEval at_y = scatter_eval(scene_, y, -wi);
    c = v.beta * at_v.f * at_y.f * y.beta * (raised / d2);
    if (is_black(c)) {
      return;
    }
    const double inverse_d2 = 1.0 / static_cast<double>(d2);
    const double from_light =
        static_cast<double>(at_y.pdf) * static_cast<double>(abs_cosine(v.point, wi)) * inverse_d2;
    const double from_camera =
        static_cast<double>(at_v.pdf) * static_cast<double>(abs_cosine(y.point, wi)) * inverse_d2;
    double others = y.mis.sum(heuristic_, from_camera, static_cast<double>(at_y.pdf_reverse));
    if (v.other_reaches) {
      others += v.mis.sum(heuristic_, from_light, static_cast<double>(at_v.pdf_reverse));
    }
    if (!plan_.worthwhile(c, techniques_.weight(others), u.y)) {
      return;
    }
    bool blocked = false;
    c *= transmittance<F.transparent>(segments(), spawn_segment(v.point, y.point), walk.depth,
                                      &blocked);
    if (!blocked) {
      add_reaching(walk, kLobeAny, false,
                   {s, walk.depth.total + 2, light_number_, &y, &v, wi, distance, others, c});
    }
  }

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

  LightEnds light_ends() const { return {scene_, plan_.guide, heuristic_}; }
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
  const WalkContext walks_;
  RenderStats& stats_;
  const FilteredSplats splats_;
  Subpath& light_;
  Subpath& camera_path_;
  CameraFilm<F.passes> film_;
  std::conditional_t<F.passes, LightPasses, NoPasses> passes_;
  Observer& observer_;
  Color radiance_;
  uint32_t light_number_ = kNoIndex;  // of the light's sub-path
  float start_distance_ = 0.0f;
  double light_paths_;  // as many as samples of all pixels that are rendered
  double light_share_;  // over the samples of the full frame
};

}  // namespace vernier
