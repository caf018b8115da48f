#include "integrators/bidirectional.h"

#include "bidirectional/tracer.h"

namespace vernier {
namespace {

template <BidirectionalFeatures F>
void render_bidirectional_tile(const RenderContext& context, const Batch& batch, const Tile& tile,
                               TileBuffer& buffer, PassSet /*passes*/, RenderStats& stats) {
  BidirectionalMemory memory;
  NoObserver observer;
  const SharedPaths* shared = nullptr;
  if constexpr (!F.merging) {
    shared = static_cast<const SharedPaths*>(context.light_pass);
  }
  render_camera_tile<F.passes>(
      context, batch, tile, buffer, stats,
      [&](const CameraRay& ray, const SobolSampler& sampler, auto& pass_sample) {
        return BidirectionalTracer<F>(context, sampler, stats, buffer.splats(), pass_sample, memory,
                                      observer, shared)
            .run(ray);
      });
}

// What the user should know of the techniques that are left out.
std::vector<std::string> describe_limits(const Settings& settings,
                                         const Requirements& requirements) {
  const TechniqueSet techniques(settings, requirements);
  const std::string uneven =
      "some objects are visible to some kinds of scattered rays and hidden from others";
  std::vector<std::string> notes;
  if (techniques.camera_paths) {
    if (!techniques.light_paths) {
      notes.push_back(std::string(TechniqueSet::vcm(settings) ? "Vertex Connection and Merging"
                                                              : "Bidirectional Path Tracing") +
                      " starts no paths at lights here: " + uneven);
    }
    if (techniques.merges) {
      notes.push_back(
          "Vertex Connection and Merging blurs light within its radius, which shrinks with the "
          "samples; the error bar leaves that out");
    }
    return notes;
  }
  if (!techniques.light_paths) {
    notes.push_back("Light Tracing finds nothing but lights seen directly here: " + uneven);
  }
  if (requirements.things_in_lamps) {
    notes.push_back(
        "Light Tracing does not light what lies within a point or spot lamp without soft falloff");
  }
  if (requirements.transmits_by_side) {
    notes.push_back(
        "Light Tracing's paths pass a surface as the side that they come from has it: what a "
        "material lets through as seen from its other side alone is left out");
  }
  if (requirements.singular_lobes) {
    notes.push_back("Light Tracing shows nothing on mirrors and through clear glass");
  }
  return notes;
}

}  // namespace

Kernel bidirectional_kernel(const Settings& settings, const Requirements& requirements,
                            PassSet passes) {
  // Indexed by the bits passes, transparent, merging.
  static constexpr RenderTile kKernels[] = {
      render_bidirectional_tile<BidirectionalFeatures{false, false}>,
      render_bidirectional_tile<BidirectionalFeatures{true, false}>,
      render_bidirectional_tile<BidirectionalFeatures{false, true}>,
      render_bidirectional_tile<BidirectionalFeatures{true, true}>,
      render_bidirectional_tile<BidirectionalFeatures{false, false, true}>,
      render_bidirectional_tile<BidirectionalFeatures{true, false, true}>,
      render_bidirectional_tile<BidirectionalFeatures{false, true, true}>,
      render_bidirectional_tile<BidirectionalFeatures{true, true, true}>,
  };
  const bool merges = TechniqueSet(settings, requirements).merges;
  const unsigned index = (passes.any_sampled() ? 1u : 0u) |
                         (requirements.transparent_shadows ? 2u : 0u) | (merges ? 4u : 0u);
  return {.render_tile = kKernels[index],
          .splats = true,
          .make_plan = make_bidirectional_plan,
          .make_light_pass = merges ? make_light_vertices : make_shared_paths,
          .single_samples = merges,
          .notes = describe_limits(settings, requirements)};
}

}  // namespace vernier
