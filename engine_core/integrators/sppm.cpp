// Stochastic progressive photon mapping (Hachisuka and Jensen 2009), in the form of Knaus and
// Zwicker (2011) that keeps nothing from pass to pass: a pass is one sample of every pixel and a
// photon map of its own, and only the radius shrinks with the passes' number. So passes are
// independent, their spread is the picture's error but for the bias of the radius, and memory is
// that of one pass however long it runs.
//
// The radius is so many pixels wide as the pixel is at the length of the camera's path: what is far
// or seen in a mirror is blurred as little in the picture as what is near, and no unit of the scene
// matters.
#include "integrators/sppm.h"

#include "integrators/photon_plan.h"
#include "integrators/photon_tracer.h"
#include "photons/photon_pass.h"
#include "photons/radius.h"

namespace vernier {
namespace {

class ProgressiveEstimator {
 public:
  ProgressiveEstimator(const RenderContext& context, const Batch& batch)
      : map_(static_cast<const PhotonPass*>(context.light_pass)->map(0)),
        kernel_(static_cast<PhotonKernel>(context.settings.photon_kernel)),
        direct_(photons_are_direct(context.settings)),
        radius_(static_cast<float>(context.settings.photon_radius) *
                progressive_radius(batch.first, context.settings.photon_alpha)) {}

  bool direct_from_photons() const { return direct_; }
  bool shows_photons() const { return false; }
  Color shown(const GatherPoint&) const { return {}; }

  template <class Each>
  void gather(const GatherPoint& at, const WalkContext<>& walks, const Each& each) const {
    // Positions are no better known than this.
    const float least = 2.0f * max_component(at.v.point.p_error);
    gather_within(map_, gathering_at(at, walks, kernel_),
                  std::max(radius_ * at.pixel_radius(at.length), least), each);
  }

 private:
  const PhotonMap& map_;
  const PhotonKernel kernel_;
  const bool direct_;
  const float radius_;  // pixels
};

std::unique_ptr<LightPass> make_pass(const RenderContext& context, const Batch& batch) {
  const Settings& settings = context.settings;
  const auto& crop = context.scene.film.crop;
  const uint64_t pixels =
      static_cast<uint64_t>(crop[2] - crop[0]) * static_cast<uint64_t>(crop[3] - crop[1]);
  PhotonOrder order;
  order.guide = &static_cast<const PhotonPlan*>(context.plan)->guide;
  order.kinds = indirect_kinds(settings);
  order.paths = settings.photon_paths > 0 ? static_cast<uint64_t>(settings.photon_paths) : pixels;
  order.most_paths = order.paths;
  std::vector<PhotonOrder> orders{order};
  if (order.kinds == 0 || order.guide->lights.size() == 0) {
    orders.front().paths = 0;
  }
  return std::make_unique<PhotonPass>(orders, batch);
}

template <PhotonFeatures F>
void render_sppm_tile(const RenderContext& context, const Batch& batch, const Tile& tile,
                      TileBuffer& buffer, PassSet /*passes*/, RenderStats& stats) {
  ProgressiveEstimator estimator(context, batch);
  render_camera_tile<F.passes>(
      context, batch, tile, buffer, stats,
      [&](const CameraRay& ray, const SobolSampler& sampler, auto& pass_sample) {
        return PhotonTracer<F, ProgressiveEstimator>(context, sampler, stats, pass_sample,
                                                     estimator)
            .run(ray);
      });
}

}  // namespace

Kernel sppm_kernel(const Settings& settings, const Requirements& requirements, PassSet passes) {
  // Indexed by the bits passes, transparent.
  static constexpr RenderTile kKernels[] = {
      render_sppm_tile<PhotonFeatures{false, false}>,
      render_sppm_tile<PhotonFeatures{true, false}>,
      render_sppm_tile<PhotonFeatures{false, true}>,
      render_sppm_tile<PhotonFeatures{true, true}>,
  };
  const unsigned index =
      (passes.any_sampled() ? 1u : 0u) | (requirements.transparent_shadows ? 2u : 0u);
  return {.render_tile = kKernels[index],
          .make_plan = make_sppm_plan,
          .make_light_pass = make_pass,
          .single_samples = true,
          .notes = describe_photon_limits(settings, requirements)};
}

}  // namespace vernier
