// The loop over a tile's pixels and samples that integrators starting at the camera share.
#pragma once

#include <type_traits>

#include "camera/camera.h"
#include "integrators/integrator.h"
#include "sampling/dimensions.h"
#include "sampling/sobol.h"

namespace vernier {

// Radiance that arrives along a camera ray, and how much of the ray something stopped.
struct CameraSample {
  Color radiance;
  float alpha = 1.0f;
};

// Limits what one sample adds, where `limit` is not 0: biased.
inline Color clamp_sample(Color c, double limit) {
  const auto most = static_cast<float>(limit);
  const float largest = max_component(c);
  return most > 0.0f && largest > most ? c * (most / largest) : c;
}

// Stands for a PassSample where no passes are asked for.
struct NoPassSample {};

// Calls `li(ray, sampler, pass_sample)` for every sample and adds the results. Samples that are
// not finite are dropped and counted: they never reach the film.
template <bool Passes, class Li>
void render_camera_tile(const RenderContext& context, const Batch& batch, const Tile& tile,
                        TileBuffer& buffer, RenderStats& stats, const Li& li) {
  const Scene& scene = context.scene;
  for (int y = 0; y < tile.height; ++y) {
    for (int x = 0; x < tile.width; ++x) {
      const int frame_x = tile.x + x + scene.film.crop[0];
      const int frame_y = tile.y + y + scene.film.crop[1];
      PixelBatch& pixel = buffer.pixel(x, y);
      for (uint32_t s = 0; s < batch.samples; ++s) {
        if (context.cancelled.load(std::memory_order_relaxed)) {
          return;
        }
        const SobolSampler sampler(static_cast<uint32_t>(frame_x), static_cast<uint32_t>(frame_y),
                                   batch.point + s, batch.log2_capacity, batch.seed);
        const Vec2f offset = context.filter.sample(sampler.get_2d(dimension(CameraDim::kFilter)));
        const Vec2f raster{static_cast<float>(frame_x) + 0.5f + offset.x,
                           static_cast<float>(frame_y) + 0.5f + offset.y};
        const CameraRay camera_ray = scene.camera->generate_ray(
            raster,
            scene.camera->is_pinhole() ? Vec2f{} : sampler.get_2d(dimension(CameraDim::kLens)));
        std::conditional_t<Passes, PassSample, NoPassSample> pass_sample;
        CameraSample sample = li(camera_ray, sampler, pass_sample);
        ++stats.camera_paths;
        if (!is_finite(sample.radiance) || !std::isfinite(sample.alpha)) {
          ++stats.non_finite;
          sample = {Color{}, 0.0f};
          pass_sample = {};
        }
        pixel.add(sample.radiance, sample.alpha);
        if constexpr (Passes) {
          buffer.add_passes(x, y, pass_sample, batch.first + s == 0);
        }
      }
    }
  }
}

}  // namespace vernier
