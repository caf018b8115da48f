// A picture of few pixels, as a pilot finds it.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "math/vec.h"
#include "scene/description.h"

namespace vernier {

// Tells how bright the picture is about a place: what its error there is relative to.
class CoarsePicture {
 public:
  static constexpr int kSide = 16;
  static constexpr size_t kPixels = kSide * kSide;

  explicit CoarsePicture(const FilmDesc& film) : crop_(film.crop) {}

  // The number of the pixel at `raster`, pixels of the full frame; the nearest of those there are.
  uint32_t pixel(Vec2f raster) const {
    const auto along = [](float at, int32_t first, int32_t last) {
      const float part = (at - static_cast<float>(first)) / static_cast<float>(last - first);
      return std::clamp(static_cast<int>(part * kSide), 0, kSide - 1);
    };
    return static_cast<uint32_t>(along(raster.y, crop_[1], crop_[3]) * kSide +
                                 along(raster.x, crop_[0], crop_[2]));
  }
  // Light of a sample there, or of a splat: the splats of as many samples as the frame has pixels
  // make the frame.
  void add(uint32_t pixel, float amount) {
    light_[pixel] += static_cast<double>(amount) * static_cast<double>(kPixels);
  }
  void count_sample() { samples_ += 1.0; }
  void add(const CoarsePicture& other) {
    for (size_t i = 0; i < kPixels; ++i) {
      light_[i] += other.light_[i];
    }
    samples_ += other.samples_;
  }

  double samples() const { return samples_; }
  // How bright each pixel counts as: those that are darker than a part of the mean, as that bright.
  std::array<double, kPixels> brightness() const {
    std::array<double, kPixels> result{};
    double mean = 0.0;
    for (size_t i = 0; i < kPixels; ++i) {
      result[i] = light_[i] / samples_;
      mean += result[i] / static_cast<double>(kPixels);
    }
    for (double& pixel : result) {
      pixel += kDarkest * mean;
    }
    return result;
  }

 private:
  // That of the relative squared error (I - R)^2 / (R^2 + 0.01 mean(R)^2).
  static constexpr double kDarkest = 0.1;

  std::array<int32_t, 4> crop_;
  std::array<double, kPixels> light_{};
  double samples_ = 0.0;
};

}  // namespace vernier
