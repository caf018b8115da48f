// The estimator. With throughput beta over the vertices so far, every vertex adds
//   beta * Le * w_b            light that the ray met: w_b weighs this technique, and
//   beta * f * L / p_l * w_l   light that was sampled (next-event estimation),
// with w the power heuristic of the densities of both (Veach 1997, equation 9.13), where both
// could have found the light, and 1 where only one could. The estimators of `direct_light` differ
// in which of the two terms they use and in how the next direction is drawn.
#include "integrators/path.h"

#include "bsdf/bsdf.h"
#include "integrators/camera_film.h"
#include "integrators/camera_loop.h"
#include "integrators/light_passes.h"
#include "lights/light_sampler.h"
#include "math/warp.h"
#include "nodes/material.h"
#include "paths/bounce_limits.h"
#include "paths/mis.h"
#include "paths/roulette.h"
#include "paths/spawn.h"
#include "paths/visibility.h"

namespace vernier {
namespace {

// What a kernel is compiled for.
struct Features {
  bool passes;       // more than the picture is asked for
  bool transparent;  // shadow rays may pass surfaces
  bool mis;          // direct_light is MIS: the others share one kernel
};

// A path without end (no roulette, no limit, no loss) must still hear a cancel.
constexpr uint32_t kPollVertices = 256;

// Lobes of microfacets up to this alpha fill less than about a third of the hemisphere, 4 alpha^2
// of it: two samples of a plain world in three would be lost there.
constexpr float kNarrow = 0.3f;

// Uniform over the directions that the surface scatters to: the naive path tracer.
struct UniformDirection {
  Vec3f wi;
  float pdf;
};
UniformDirection sample_uniform(const SurfacePoint& point, bool transmits, Vec2f u) {
  if (transmits) {
    return {square_to_uniform_sphere(u), kInvFourPi};
  }
  return {Frame(point.ns).to_world(square_to_uniform_hemisphere(u)), kInvTwoPi};
}

// The walk of one camera path.
template <Features F>
class PathTracer {
 public:
  using Passes = std::conditional_t<F.passes, PassSample, NoPassSample>;

  PathTracer(const RenderContext& context, const SobolSampler& sampler, RenderStats& stats,
             Passes& pass_sample)
      : scene_(context.scene),
        lights_(*context.scene.lights),
        settings_(context.settings),
        cancelled_(context.cancelled),
        sampler_(sampler),
        stats_(stats),
        limits_(context.settings),
        roulette_(context.settings),
        strategy_(F.mis ? DirectLight::kMis
                        : static_cast<DirectLight>(context.settings.direct_light)),
        uniform_world_(lights_.has_uniform_environment()),
        film_(context.scene, pass_sample),
        passes_(pass_sample) {}

  CameraSample run(const CameraRay& camera_ray) {
    Ray ray = camera_ray.ray;
    const float to_camera = camera_ray.start_distance;
    Bsdf bsdf;
    for (uint32_t vertex = 0;; ++vertex) {
      if (vertex % kPollVertices == kPollVertices - 1 &&
          cancelled_.load(std::memory_order_relaxed)) {
        break;
      }
      Hit hit;
      ++stats_.rays;
      const bool found = scene_.intersect(ray, ray_mask_, hit);
      if (found) {
        ray.t_max = hit.t;
      }
      if (lights_.has_lamp_hits(ray_mask_)) {
        lights_.for_each_lamp_hit(receiver(), ray, ray_mask_, travelled_,
                                  [&](const LightHit& lamp) { add_met(lamp, false); });
      }
      if (!found) {
        escape(ray);
        break;
      }
      SurfacePoint point = scene_.surface_point(ray, hit);
      point.ray_flags = ray_flags_;
      point.depth = depth_;
      travelled_ += point.ray_length;
      const Material& material = *scene_.materials[point.material];
      bsdf.begin(point);
      material.evaluate(point, bsdf);
      bsdf.finish();
      if (on_film_) {
        film_.surface(point, bsdf, beta_, to_camera + travelled_);
      }
      if (!is_black(bsdf.emission)) {
        add_emission(point, bsdf.emission);
      }
      if (bsdf.lobes() == 0 || (spent_ && is_black(bsdf.transparency))) {
        break;
      }
      here_ = Receiver(point, (bsdf.lobes() & kLobeTransmission) != 0);
      here_.complemented = strategy_ == DirectLight::kMis;
      here_.narrow = uniform_world_ && bsdf.widest_alpha() < kNarrow;
      draws_ = sampler_.get_2d_run<kDraws>(dimension(vertex, BounceDim{}));
      if (!sample_light(point, bsdf) || !continue_path(vertex, point, bsdf, ray)) {
        break;
      }
    }
    return {radiance_, film_.alpha()};
  }

 private:
  static constexpr auto kDraws = static_cast<uint32_t>(BounceDim::kLightChoice) + 1;

  Vec2f draw(BounceDim d) const { return draws_[static_cast<size_t>(d)]; }

  // Where the current direction was sampled with a density, or null.
  const Receiver* receiver() const { return pdf_ > 0.0f ? &receiver_ : nullptr; }

  // Adds light to the picture and, where asked for, to its passes.
  template <class ToPasses>
  void add(Color contribution, bool direct, const ToPasses& to_passes) {
    const double limit = direct ? settings_.clamp_direct : settings_.clamp_indirect;
    const Color c = clamp_sample(contribution, limit);
    radiance_ += c;
    if constexpr (F.passes) {
      to_passes(passes_, c);
    }
  }

  // The weight of light that the ray met, which light sampling would have found with density
  // `pdf_light` (0: never).
  float met_weight(float pdf_light) const {
    if (pdf_ <= 0.0f || pdf_light <= 0.0f) {
      return 1.0f;  // a singular bounce, the camera, or a light that is not sampled
    }
    switch (strategy_) {
      case DirectLight::kMis:
        return power_heuristic(pdf_, pdf_light);
      case DirectLight::kLight:
        return 0.0f;
      case DirectLight::kBsdf:
      case DirectLight::kUniform:
        return 1.0f;
      case DirectLight::kMixture: {
        // One sample from two techniques: the balance heuristic. beta carries 1/(1 - q) for the
        // choice of this one.
        const float q = static_cast<float>(settings_.light_fraction);
        return (1.0f - q) * pdf_ / ((1.0f - q) * pdf_ + q * pdf_light);
      }
    }
    return 1.0f;
  }

  void add_met(const LightHit& light, bool environment) {
    const Color c = beta_ * light.radiance * met_weight(light.pdf);
    add(c, depth_.total <= 1,
        [&](auto& passes, Color l) { passes.add_met(depth_.total, environment, l); });
  }

  void add_emission(const SurfacePoint& point, Color emission) {
    float pdf_light = 0.0f;
    if (pdf_ > 0.0f) {
      pdf_light = lights_.pdf_triangle(receiver_, point.instance, point.triangle, -point.wo,
                                       travelled_, std::abs(dot(point.ng, point.wo)));
    }
    add(beta_ * emission * met_weight(pdf_light), depth_.total <= 1,
        [&](auto& passes, Color l) { passes.add_met(depth_.total, false, l); });
  }

  // The ray has left the scene.
  void escape(const Ray& ray) {
    if (on_film_ && scene_.film.transparent) {
      film_.uncover(beta_);
      return;
    }
    if (lights_.has_escapes(ray_mask_)) {
      lights_.for_each_escape(receiver(), ray.d, ray_mask_, ray_flags_, depth_,
                              [&](const LightHit& light) { add_met(light, true); });
    }
  }

  // Next-event estimation. False where the mixture estimator chose it, and the path ends here.
  bool sample_light(const SurfacePoint& point, const Bsdf& bsdf) {
    if (!bsdf.connectible() || lights_.count() == 0 || !next_depth_allowed()) {
      return true;
    }
    const bool mixture = strategy_ == DirectLight::kMixture;
    const Vec2f choice = draw(BounceDim::kLightChoice);
    const float q = static_cast<float>(settings_.light_fraction);
    const bool toward_light = !mixture || choice.y < q;
    LightSample light;
    if (lights_.sample(here_, choice.x, draw(BounceDim::kLightPoint), light)) {
      add_light(point, bsdf, light, toward_light);
    }
    if (mixture && toward_light) {
      return false;
    }
    if (mixture) {
      beta_ *= 1.0f / (1.0f - q);
    }
    return true;
  }

  // The weight of sampled light whose direction the BSDF would have drawn with density `pdf_bsdf`.
  // Lights that no ray can meet belong to light sampling whatever the strategy.
  float sampled_weight(const LightSample& light, float pdf_bsdf, bool toward_light) const {
    if (!light.hittable) {
      return 1.0f;
    }
    switch (strategy_) {
      case DirectLight::kMis:
        return power_heuristic(light.pdf, pdf_bsdf);
      case DirectLight::kLight:
        return 1.0f;
      case DirectLight::kBsdf:
      case DirectLight::kUniform:
        return 0.0f;
      case DirectLight::kMixture: {
        const float q = static_cast<float>(settings_.light_fraction);
        return toward_light ? light.pdf / (q * light.pdf + (1.0f - q) * pdf_bsdf) : 0.0f;
      }
    }
    return 1.0f;
  }

  void add_light(const SurfacePoint& point, const Bsdf& bsdf, const LightSample& light,
                 bool toward_light) {
    const uint8_t mask = lobes_lit(light.visibility);
    const BsdfEval eval = bsdf.eval_forward(light.wi, Transport::kRadiance, mask);
    const float weight = sampled_weight(light, eval.pdf, toward_light);
    Color c = beta_ * eval.f * light.radiance * (weight / light.pdf);
    if (is_black(c) || !is_finite(c)) {
      stats_.non_finite += is_finite(c) ? 0u : 1u;
      return;
    }
    if (light.cast_shadow) {
      c *= transmittance<F.transparent>({scene_, limits_.transparent, stats_.rays},
                                        spawn_shadow_ray(point, light), depth_);
      if (is_black(c)) {
        return;
      }
    }
    add(c, depth_.total == 0, [&](auto& passes, Color l) {
      if (depth_.total == 0) {
        passes.add_first_light(bsdf, light.wi, mask, l);
      } else {
        passes.add_later_light(l);
      }
    });
  }

  // Whether light that arrives by one more bounce is within the limit on all bounces.
  bool next_depth_allowed() const { return depth_.total < limits_.total && !spent_; }

  // Draws the next direction. Empty: the path ends.
  std::optional<BsdfSample> next_direction(const SurfacePoint& point, const Bsdf& bsdf) const {
    const Vec2f u = draw(BounceDim::kDirection);
    const float u_lobe = draw(BounceDim::kLobe).x;
    if (strategy_ != DirectLight::kUniform || !bsdf.connectible()) {
      return bsdf.sample_forward(u_lobe, u, Transport::kRadiance);
    }
    // Uniform sampling cannot find singular lobes: with an even chance one of them is drawn
    // instead, and each half counts double.
    const bool both = (bsdf.lobes() & kLobeSingular) != 0;
    const float scale = both ? 2.0f : 1.0f;
    if (both && u_lobe >= 0.5f) {
      auto sample = bsdf.sample_forward(2.0f * u_lobe - 1.0f, u, Transport::kRadiance);
      if (!sample || (sample->lobe & kLobeSingular) == 0) {
        return std::nullopt;
      }
      sample->weight *= scale;
      return sample;
    }
    const bool transmits = (bsdf.lobes() & kLobeTransmission) != 0;
    const UniformDirection uniform = sample_uniform(point, transmits, u);
    BsdfSample sample;
    sample.wi = uniform.wi;
    sample.pdf = uniform.pdf;
    sample.weight = bsdf.eval_forward(uniform.wi, Transport::kRadiance).f * (scale / uniform.pdf);
    const bool through = dot(uniform.wi, point.ng) < 0.0f;
    const bool diffuse = (bsdf.lobes() & kLobeDiffuse) != 0;
    sample.lobe = static_cast<uint8_t>((through ? kLobeTransmission : kLobeReflection) |
                                       (diffuse ? kLobeDiffuse : kLobeGlossy));
    return sample;
  }

  // Scatters, and sets up the ray to the next vertex. False where the path ends.
  bool continue_path(uint32_t vertex, const SurfacePoint& point, const Bsdf& bsdf, Ray& ray) {
    const auto sample = next_direction(point, bsdf);
    if (!sample || is_black(sample->weight)) {
      return false;
    }
    const bool straight = (sample->lobe & kLobeTransparent) != 0;
    if (spent_ && !straight) {
      return false;
    }
    if constexpr (F.passes) {
      if (depth_.total == 0 && !straight) {
        passes_.first_bounce(bsdf, *sample);
      }
    }
    scatter(sample->lobe, depth_, ray_flags_, ray_mask_);
    if (!limits_.allow(depth_)) {
      return false;
    }
    spent_ = limits_.spent(depth_);
    beta_ *= sample->weight;
    if (!survive_roulette(vertex)) {
      return false;
    }
    if (!straight) {
      on_film_ = false;
      travelled_ = 0.0f;
      const bool singular = (sample->lobe & kLobeSingular) != 0;
      pdf_ = singular ? 0.0f : sample->pdf;
      if (!singular) {
        receiver_ = here_;
      }
    }
    ray = spawn_ray(point, sample->wi);
    return true;
  }

  bool survive_roulette(uint32_t vertex) {
    const float survival = roulette_.survival(depth_.total, vertex, max_component(beta_));
    if (!(draw(BounceDim::kLobe).y < survival)) {
      return false;
    }
    if (survival < 1.0f) {
      beta_ *= 1.0f / survival;
    }
    return true;
  }

  const Scene& scene_;
  const LightSampler& lights_;
  const Settings& settings_;
  const std::atomic<bool>& cancelled_;
  const SobolSampler& sampler_;
  RenderStats& stats_;
  const BounceLimits limits_;
  const Roulette roulette_;
  const DirectLight strategy_;
  const bool uniform_world_;
  CameraFilm<F.passes> film_;
  std::conditional_t<F.passes, LightPasses, NoPasses> passes_;

  std::array<Vec2f, kDraws> draws_;  // of this vertex
  Color radiance_;
  Color beta_ = splat(1.0f);
  bool spent_ = false;      // the limits leave nothing but to meet a light
  bool on_film_ = true;     // nothing but transparent surfaces since the camera
  float pdf_ = 0.0f;        // of the current direction; 0: camera, or a singular bounce
  float travelled_ = 0.0f;  // distance from receiver_ along it
  Receiver receiver_;       // where it was sampled
  Receiver here_;           // the current vertex
  PathDepth depth_;
  uint32_t ray_flags_ = kRayCamera;
  uint32_t ray_mask_ = kVisibleCamera;
};

template <Features F>
void render_path_tile(const RenderContext& context, const Batch& batch, const Tile& tile,
                      TileBuffer& buffer, PassSet /*passes*/, RenderStats& stats) {
  render_camera_tile<F.passes>(
      context, batch, tile, buffer, stats,
      [&](const CameraRay& ray, const SobolSampler& sampler, auto& pass_sample) {
        return PathTracer<F>(context, sampler, stats, pass_sample).run(ray);
      });
}

}  // namespace

RenderTile path_kernel(const Settings& settings, const Requirements& requirements, PassSet passes) {
  // Indexed by the bits passes, transparent, mis.
  static constexpr RenderTile kKernels[] = {
      render_path_tile<Features{false, false, false}>,
      render_path_tile<Features{true, false, false}>,
      render_path_tile<Features{false, true, false}>,
      render_path_tile<Features{true, true, false}>,
      render_path_tile<Features{false, false, true}>,
      render_path_tile<Features{true, false, true}>,
      render_path_tile<Features{false, true, true}>,
      render_path_tile<Features{true, true, true}>,
  };
  const unsigned index =
      (passes.any_sampled() ? 1u : 0u) | (requirements.transparent_shadows ? 2u : 0u) |
      (static_cast<DirectLight>(settings.direct_light) == DirectLight::kMis ? 4u : 0u);
  return kKernels[index];
}

}  // namespace vernier
