// Photon mapping as Jensen has it (2001, "Realistic Image Synthesis Using Photon Mapping"): a map
// of caustics and a global map, both of a size that is asked for, and radiance from the nearest
// photons of each. Paths of light are told apart by what they have been through before the point:
//   nothing                      direct light: shadow rays, or the global map on demand;
//   specular surfaces alone      the caustic map, of photons that are aimed at such surfaces;
//   anything else                the global map, or a final gather: rays over the hemisphere, at
//                                whose ends direct light and both maps are asked.
// Every path has one of these and so counts once. Each pass makes new maps: the picture is the mean
// over maps, whose spread the error bar shows. What it does not show is the bias of gathering from
// an area, which more photons make smaller and more passes do not.
#include "integrators/photon_map_integrator.h"

#include "integrators/photon_plan.h"
#include "integrators/photon_tracer.h"
#include "photons/photon_pass.h"

namespace vernier {
namespace {

// The radiance of a photon that is shown: bright dots of this, at the mean power.
constexpr float kShownRadiance = 1.0f;

// What a thread keeps from sample to sample.
struct MapMemory {
  std::vector<KdNeighbour> found;
};

class MapEstimator {
 public:
  MapEstimator(const RenderContext& context, MapMemory& memory, bool final_gather,
               RenderStats& stats)
      : context_(context),
        stats_(stats),
        memory_(memory),
        kernel_(static_cast<PhotonKernel>(context.settings.photon_kernel)),
        direct_(photons_are_direct(context.settings)),
        view_(static_cast<PhotonView>(context.settings.photon_view)),
        rays_(final_gather ? context.settings.final_gather_rays : 0),
        radius_(static_cast<float>(context.settings.photon_most_radius)) {
    const auto& plan = *static_cast<const PhotonPlan*>(context.plan);
    const auto& pass = *static_cast<const PhotonPass*>(context.light_pass);
    global_ = plan.global_map >= 0 ? &pass.map(static_cast<size_t>(plan.global_map)) : nullptr;
    caustics_ = plan.caustic_map >= 0 ? &pass.map(static_cast<size_t>(plan.caustic_map)) : nullptr;
    memory_.found.resize(static_cast<size_t>(context.settings.photon_neighbours));
  }

  bool direct_from_photons() const { return direct_ && rays_ == 0; }
  bool shows_photons() const { return view_ != PhotonView::kOff; }

  // Dots of a pixel's size, of the photons' colours.
  Color shown(const GatherPoint& at) const {
    const PhotonMap* map = view_ == PhotonView::kCaustic ? caustics_ : global_;
    if (map == nullptr || map->size() == 0) {
      return {};
    }
    const auto mean =
        static_cast<float>(map->tally().emitted / static_cast<double>(map->tally().paths));
    Color sum;
    map->tree().for_each(at.v.point.p, square(at.pixel_radius(at.length)),
                         [&](uint32_t place, float) { sum += map->photon(place).power; });
    return mean > 0.0f ? sum * (kShownRadiance / mean) : Color{};
  }

  template <class Each>
  void gather(const GatherPoint& at, const WalkContext<>& walks, const Each& each) {
    const Gathering g = gathering_at(at, walks, kernel_);
    const float radius = radius_ * at.pixel_radius(at.length);
    if (caustics_ != nullptr) {
      gather_nearest(*caustics_, g, radius, memory_.found, each);
    }
    if (rays_ > 0) {
      gather_finally(at, walks, each);
    } else if (global_ != nullptr) {
      gather_nearest(*global_, g, radius, memory_.found, each);
    }
  }

 private:
  // Rays by the gathered lobes, at whose ends the maps are asked.
  template <class Each>
  void gather_finally(const GatherPoint& at, const WalkContext<>& walks, const Each& each) {
    const PathVertex& v = at.v;
    const Vec2f choice = at.walk.draw(BounceDim::kLobe), u = at.walk.draw(BounceDim::kDirection);
    const float part = 1.0f / static_cast<float>(rays_);
    for (int i = 0; i < rays_; ++i) {
      const auto number = static_cast<uint32_t>(i);
      // A lattice, shifted as a whole: one ray in each of the slices.
      const float slice = (u.x + static_cast<float>(i)) * part;
      const auto sample = v.bsdf.sample_forward(
          rotate(choice.x, number), {std::min(slice, kOneMinusEpsilon), rotate(u.y, number)},
          Transport::kRadiance, at.lobes);
      if (!sample) {
        continue;
      }
      Walk walk;
      walk.depth = at.walk.depth;
      walk.flags = at.walk.flags;
      walk.mask = at.walk.mask;
      scatter(sample->lobe, walk.depth, walk.flags, walk.mask);
      if (!walks.limits.allow(walk.depth)) {
        continue;
      }
      walk.spent = walks.limits.spent(walk.depth);
      walk.ray = spawn_ray(v.point, sample->wi);
      const SobolSampler sampler = walks.sampler.another(at.walk.index + 1, number);
      MapEstimator maps(context_, ends_, false, stats_);
      NoPassSample none;
      const Color arriving = PhotonTracer<PhotonFeatures{false, true}, MapEstimator>(
                                 context_, sampler, stats_, none, maps)
                                 .run_from(walk, at);
      each(sample->wi, sample->weight * arriving * part, false);
    }
  }

  const RenderContext& context_;
  RenderStats& stats_;
  MapMemory& memory_;
  MapMemory ends_;  // of final gather rays
  const PhotonMap* global_;
  const PhotonMap* caustics_;
  const PhotonKernel kernel_;
  const bool direct_;
  const PhotonView view_;
  const int rays_;
  const float radius_;  // pixels
};

std::unique_ptr<LightPass> make_pass(const RenderContext& context, const Batch& batch) {
  const auto& plan = *static_cast<const PhotonPlan*>(context.plan);
  Batch own = batch;
  if (static_cast<PhotonView>(context.settings.photon_view) != PhotonView::kOff) {
    own.first = 0;  // dots stay where they are
  }
  return std::make_unique<PhotonPass>(plan.orders(), own);
}

template <PhotonFeatures F>
void render_photon_tile(const RenderContext& context, const Batch& batch, const Tile& tile,
                        TileBuffer& buffer, PassSet /*passes*/, RenderStats& stats) {
  MapMemory memory;
  MapEstimator estimator(context, memory, true, stats);
  render_camera_tile<F.passes>(
      context, batch, tile, buffer, stats,
      [&](const CameraRay& ray, const SobolSampler& sampler, auto& pass_sample) {
        return PhotonTracer<F, MapEstimator>(context, sampler, stats, pass_sample, estimator)
            .run(ray);
      });
}

}  // namespace

Kernel photon_map_kernel(const Settings& settings, const Requirements& requirements,
                         PassSet passes) {
  // Indexed by the bits passes, transparent.
  static constexpr RenderTile kKernels[] = {
      render_photon_tile<PhotonFeatures{false, false}>,
      render_photon_tile<PhotonFeatures{true, false}>,
      render_photon_tile<PhotonFeatures{false, true}>,
      render_photon_tile<PhotonFeatures{true, true}>,
  };
  const unsigned index =
      (passes.any_sampled() ? 1u : 0u) | (requirements.transparent_shadows ? 2u : 0u);
  std::vector<std::string> notes = describe_photon_limits(settings, requirements);
  for (std::string& note : describe_photon_maps(settings, requirements)) {
    notes.push_back(std::move(note));
  }
  return {.render_tile = kKernels[index],
          .make_plan = make_photon_map_plan,
          .make_light_pass = make_pass,
          .single_samples = true,
          .notes = std::move(notes)};
}

}  // namespace vernier
