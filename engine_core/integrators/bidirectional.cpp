#include "integrators/bidirectional.h"

#include "integrators/bidirectional_tracer.h"

namespace vernier {
namespace {

template <BidirectionalFeatures F>
void render_bidirectional_tile(const RenderContext& context, const Batch& batch, const Tile& tile,
                               TileBuffer& buffer, PassSet /*passes*/, RenderStats& stats) {
  BidirectionalMemory memory;
  NoObserver observer;
  render_camera_tile<F.passes>(
      context, batch, tile, buffer, stats,
      [&](const CameraRay& ray, const SobolSampler& sampler, auto& pass_sample) {
        return BidirectionalTracer<F>(context, sampler, stats, buffer.splats(), pass_sample, memory,
                                      observer)
            .run(ray);
      });
}

}  // namespace

Kernel bidirectional_kernel(const Settings&, const Requirements& requirements, PassSet passes) {
  // Indexed by the bits passes, transparent.
  static constexpr RenderTile kKernels[] = {
      render_bidirectional_tile<BidirectionalFeatures{false, false}>,
      render_bidirectional_tile<BidirectionalFeatures{true, false}>,
      render_bidirectional_tile<BidirectionalFeatures{false, true}>,
      render_bidirectional_tile<BidirectionalFeatures{true, true}>,
  };
  const unsigned index =
      (passes.any_sampled() ? 1u : 0u) | (requirements.transparent_shadows ? 2u : 0u);
  return {kKernels[index], true, make_bidirectional_plan};
}

}  // namespace vernier
