// The loop over the samples of a pilot, which finds out about the scene before the first batch.
#pragma once

#include "bidirectional/tracer.h"
#include "math/float_environment.h"

namespace vernier {

// A sequence of its own: no sample of the picture sees these numbers.
inline uint64_t pilot_seed(uint64_t seed) { return hash64(~seed); }

// Samples `first` to `last` of 2^log2_samples, spread over the picture, by the plan in `context`.
// `observer` is told of every path that is found, and after each sample
//   done(raster, sample, memory).
template <bool kMerging, class Observer, class Done>
void run_pilot(const RenderContext& context, uint64_t seed, int log2_samples, uint32_t first,
               uint32_t last, const SharedPaths* shared, RenderStats& stats, Observer& observer,
               const Done& done) {
  const FlushDenormals flush;
  const Scene& scene = context.scene;
  const std::array<int32_t, 4>& crop = scene.film.crop;
  BidirectionalMemory memory;
  for (uint32_t i = first; i < last && !context.cancelled; ++i) {
    const SobolSampler sampler(0, 0, i, log2_samples, pilot_seed(seed));
    const Vec2f u = sampler.get_2d(dimension(CameraDim::kFilter));
    const Vec2f raster{lerp(static_cast<float>(crop[0]), static_cast<float>(crop[2]), u.x),
                       lerp(static_cast<float>(crop[1]), static_cast<float>(crop[3]), u.y)};
    const CameraRay ray =
        scene.camera->generate_ray(raster, sampler.get_2d(dimension(CameraDim::kLens)));
    NoPassSample no_passes;
    const CameraSample sample =
        BidirectionalTracer<BidirectionalFeatures{false, true, kMerging}, Observer>(
            context, sampler, stats, nullptr, no_passes, memory, observer, shared)
            .run(ray);
    done(raster, sample, memory);
  }
}

}  // namespace vernier
