// The camera's part of photon methods.
//
// A path follows the lobes that show no photons (photons/lobe_split.h): mirrors, glass, sharp
// gloss. At each of its vertices the other lobes gather photons and go no further, and lights are
// sampled for all lobes. Lights that the path meets itself count in full after singular scattering,
// and share with light sampling after sharp gloss; no gathered lobe is ever followed to one.
#pragma once

#include "integrators/camera_film.h"
#include "integrators/camera_loop.h"
#include "integrators/met_lights.h"
#include "lights/light_sampler.h"
#include "paths/light_end.h"
#include "paths/mis.h"
#include "paths/random_walk.h"
#include "paths/visibility.h"
#include "photons/gather.h"

namespace vernier {

// What a tracer is compiled for.
struct PhotonFeatures {
  bool passes;       // more than the picture is asked for
  bool transparent;  // shadows may pass surfaces
};

// The roulette of the camera's paths. What a floor reflects stands beside photons that are smooth
// from the first sample on, and a path that is ended there is a dark speck. Such paths end where
// photons are gathered; so only those are ended before that carry a small part of what others may.
inline Roulette eye_roulette(const Settings& settings) {
  constexpr double kPart = 0.04;
  return {settings, static_cast<float>(kPart * settings.roulette_threshold),
          settings.roulette_start};
}

// A vertex that gathers: what estimators of its photons' light are told.
struct GatherPoint {
  const PathVertex& v;
  const Walk& walk;
  uint8_t lobes;   // that gather
  float length;    // of the path, metres
  const Ray& eye;  // where it started

  // Of the disk that a pixel covers where a straight path is so long, metres.
  float pixel_radius(float path_length) const {
    return v.point.scene->footprint(eye.o + eye.d * path_length);
  }
};

// The photons that a point may gather.
inline Gathering gathering_at(const GatherPoint& at, const WalkContext<>& walks,
                              PhotonKernel kernel) {
  return {at.v, at.lobes, walks.limits.total - at.walk.depth.total - 1, kernel};
}

// Estimator:
//   bool direct_from_photons() const              lights are not sampled for gathered lobes;
//   bool shows_photons() const                    the picture is of the photons themselves;
//   Color shown(const GatherPoint&)               that picture;
//   void gather(const GatherPoint&, const WalkContext<>&, const Each&)
//                                                 calls each(wi, radiance, direct), the path's
//                                                 throughput not included.
template <PhotonFeatures F, class Estimator>
class PhotonTracer {
 public:
  using Passes = std::conditional_t<F.passes, PassSample, NoPassSample>;

  PhotonTracer(const RenderContext& context, const SobolSampler& sampler, RenderStats& stats,
               Passes& passes, Estimator& estimator)
      : scene_(context.scene),
        lights_(*context.scene.lights),
        settings_(context.settings),
        walks_{context.scene,
               sampler,
               context.cancelled,
               BounceLimits(context.settings),
               eye_roulette(context.settings),
               stats.rays},
        film_(context.scene, passes),
        passes_(passes),
        estimator_(estimator) {}

  CameraSample run(const CameraRay& camera_ray) {
    eye_ = camera_ray.ray;
    start_distance_ = camera_ray.start_distance;
    Walk walk;
    walk.ray = camera_ray.ray;
    Visitor visitor{*this};
    random_walk(walks_, walk, visitor);
    return {radiance_, film_.alpha()};
  }

  // Light that arrives along a walk which left `from` by a gathered lobe, but for what comes from
  // lights by way of specular surfaces alone: `from` has it already.
  Color run_from(Walk& walk, const GatherPoint& from) {
    eye_ = from.eye;
    only_gathers_ = true;
    Visitor visitor{*this};
    visitor.length = from.length;
    random_walk(walks_, walk, visitor);
    return radiance_;
  }

 private:
  struct Visitor {
    PhotonTracer& tracer;
    PathVertex here{};
    Receiver receiver{};
    float pdf = 0.0f;  // of the direction that is walked
    bool singular = true;
    uint8_t gathered = 0;
    float length = 0.0f;  // of the path so far

    bool segment(const Walk& walk, const Ray& ray, bool found) {
      return tracer.meet_lights(walk, ray, found, *this);
    }
    PathVertex& vertex() { return here; }
    bool arrive(const Walk& walk, PathVertex& v) {
      length += v.point.ray_length;
      gathered = gathered_lobes(v.bsdf);
      return tracer.arrive(walk, v, *this);
    }
    uint8_t lobes(const PathVertex&) const { return followed_lobes(gathered); }
    void pass(const PathVertex&) {}
    void leave(const PathVertex& v, const BsdfSample& sample) {
      if constexpr (F.passes) {
        if (v.point.depth.total == 0) {
          tracer.passes_.first_bounce(v.bsdf, sample);
        }
      }
      receiver = receiver_of(tracer.scene_, v);
      pdf = sample.pdf;
      singular = (sample.lobe & kLobeSingular) != 0;
    }
    // Where the direction was sampled with a density, or null.
    const Receiver* sampled_from(const Walk& walk) const {
      return walk.depth.total > 0 && !singular ? &receiver : nullptr;
    }
  };

  // Lamps that the ray crosses, and where it leaves the scene what lies beyond.
  bool meet_lights(const Walk& walk, const Ray& ray, bool found, const Visitor& visitor) {
    if (estimator_.shows_photons() || only_gathers_) {
      return found;
    }
    return vernier::meet_lights(scene_, visitor.sampled_from(walk), walk, ray, found, film_,
                                [&](const LightHit& light, float, bool beyond) {
                                  add_met(walk, visitor, light.pdf, light.radiance, beyond);
                                });
  }

  // Light that the path met itself, which light sampling would have found with density `sampled`.
  void add_met(const Walk& walk, const Visitor& visitor, float sampled, Color radiance,
               bool environment) {
    const bool shared = walk.depth.total > 0 && !visitor.singular;
    const float weight = shared ? power_heuristic(visitor.pdf, sampled) : 1.0f;
    const Color c = clamp(walk.beta * radiance * weight, walk.depth.total <= 1);
    radiance_ += c;
    if constexpr (F.passes) {
      passes_.add_met(walk.depth.total, environment, c);
    }
  }

  bool arrive(const Walk& walk, PathVertex& v, const Visitor& visitor) {
    if (walk.depth.total == 0 && !only_gathers_) {
      film_.surface(v.point, v.bsdf, v.beta, start_distance_ + walk.travelled);
    }
    const GatherPoint at{v, walk, visitor.gathered, visitor.length, eye_};
    if (estimator_.shows_photons()) {
      if (at.lobes == 0) {
        return true;
      }
      radiance_ += v.beta * estimator_.shown(at);
      return false;
    }
    if (!is_black(v.bsdf.emission) && !only_gathers_) {
      const float sampled = pdf_met_surface(lights_, visitor.sampled_from(walk), walk, v.point);
      add_met(walk, visitor, sampled, v.bsdf.emission, false);
    }
    if (v.bsdf.connectible() && walk.depth.total < walks_.limits.total && !walk.spent) {
      sample_light(at);
      if (at.lobes != 0) {
        gather(at);
      }
    }
    return true;
  }

  // Next-event estimation: for lobes that gather alone, for others beside what the path meets.
  void sample_light(const GatherPoint& at) {
    const PathVertex& v = at.v;
    const auto followed = static_cast<uint8_t>(followed_lobes(at.lobes));
    const bool gathers = at.lobes != 0 && !estimator_.direct_from_photons();
    const bool follows =
        !only_gathers_ && (v.bsdf.lobes() & kLobeGlossy) != 0 && (at.lobes & kLobeGlossy) == 0;
    LightSample light;
    if (!(gathers || follows) || lights_.count() == 0 ||
        !lights_.sample(receiver_of(scene_, v), at.walk.draw(BounceDim::kLightChoice).x,
                        at.walk.draw(BounceDim::kLightPoint), light)) {
      return;
    }
    const uint8_t lit = lobes_lit(light.visibility);
    uint8_t mask = lit;
    Color f;
    if (gathers) {
      mask = static_cast<uint8_t>(follows ? lit : lit & at.lobes);
      f = v.bsdf.eval_forward(light.wi, Transport::kRadiance, lit & at.lobes).f;
    } else {
      mask = static_cast<uint8_t>(lit & followed);
    }
    if (follows) {
      f += v.bsdf.eval_forward(light.wi, Transport::kRadiance, lit & followed).f *
           (light.hittable
                ? power_heuristic(light.pdf,
                                  v.bsdf.eval_forward(light.wi, Transport::kRadiance, followed).pdf)
                : 1.0f);
    }
    Color c = v.beta * f * light.radiance * (1.0f / light.pdf);
    if (is_black(c)) {
      return;
    }
    if (light.cast_shadow) {
      c *= transmittance<F.transparent>({scene_, walks_.limits.transparent, walks_.rays},
                                        spawn_shadow_ray(v.point, light), at.walk.depth);
    }
    c = clamp(c, at.walk.depth.total == 0);
    radiance_ += c;
    add_passes(at, light.wi, mask, c, true);
  }

  void gather(const GatherPoint& at) {
    Color sum;
    estimator_.gather(at, walks_, [&](Vec3f wi, Color radiance, bool direct) {
      const Color c = at.v.beta * radiance;
      sum += c;
      add_passes(at, wi, at.lobes, c, direct);
    });
    radiance_ += clamp(sum, false);
  }

  void add_passes(const GatherPoint& at, Vec3f wi, uint8_t mask, Color c, bool direct) {
    if constexpr (F.passes) {
      if (at.walk.depth.total == 0) {
        passes_.add_first_light(at.v.bsdf, wi, mask, c, direct);
      } else {
        passes_.add_later_light(c);
      }
    }
  }

  Color clamp(Color c, bool direct) const {
    return clamp_sample(c, direct ? settings_.clamp_direct : settings_.clamp_indirect);
  }

  const Scene& scene_;
  const LightSampler& lights_;
  const Settings& settings_;
  const WalkContext<> walks_;
  CameraFilm<F.passes> film_;
  std::conditional_t<F.passes, LightPasses, NoPasses> passes_;
  Estimator& estimator_;
  Color radiance_;
  Ray eye_;
  bool only_gathers_ = false;
  float start_distance_ = 0.0f;
};

}  // namespace vernier
