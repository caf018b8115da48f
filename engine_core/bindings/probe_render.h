// What probes need of a render that no session runs.
#pragma once

#include <atomic>
#include <bit>
#include <map>
#include <memory>
#include <string>

#include "bindings/bind.h"
#include "camera/camera.h"
#include "integrators/integrator.h"
#include "sampling/dimensions.h"
#include "sampling/sobol.h"

namespace vernier {

struct ProbeRender {
  std::shared_ptr<const Scene> scene;
  Settings settings;
  PixelFilter2d filter;
  std::atomic<bool> cancelled{false};
  RenderStats stats;

  ProbeRender(nanobind::handle handle, const std::map<std::string, SettingValue>& values)
      : scene(scene_of(handle)),
        settings(make_settings(values)),
        filter(scene->film.filter, scene->film.filter_width) {}

  // Refers to this. `plan` may be null.
  RenderContext context(const Plan* plan = nullptr) const {
    return {*scene, settings, filter, cancelled, plan};
  }

  // Calls f(x, y, camera ray, sampler) for `samples` samples of every pixel of the film.
  template <class F>
  void for_each_camera_ray(uint32_t samples, uint64_t seed, const F& f) const {
    const auto& crop = scene->film.crop;
    for (int y = crop[1]; y < crop[3]; ++y) {
      for (int x = crop[0]; x < crop[2]; ++x) {
        for (uint32_t i = 0; i < samples; ++i) {
          const SobolSampler sampler(static_cast<uint32_t>(x), static_cast<uint32_t>(y), i,
                                     static_cast<int>(std::bit_width(samples - 1u)), seed);
          const Vec2f offset = filter.sample(sampler.get_2d(dimension(CameraDim::kFilter)));
          const Vec2f raster{static_cast<float>(x) + 0.5f + offset.x,
                             static_cast<float>(y) + 0.5f + offset.y};
          f(x, y, scene->camera->generate_ray(raster, sampler.get_2d(dimension(CameraDim::kLens))),
            sampler);
        }
      }
    }
  }
};

}  // namespace vernier
