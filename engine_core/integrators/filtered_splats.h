// Splats through the pixel filter.
#pragma once

#include <algorithm>
#include <cmath>

#include "integrators/light_passes.h"
#include "render/splats.h"
#include "sampling/pixel_filter.h"
#include "scene/description.h"

namespace vernier {

// Gives every pixel whose filter reaches a point its part: pixel j has filter(point - j) of it, as
// it would have by sampling the filter about its centre.
class FilteredSplats {
 public:
  // `frame` may be null: then nothing is kept.
  FilteredSplats(const FilmDesc& film, const PixelFilter2d& filter, SplatFrame* frame)
      : film_(film), filter_(filter), frame_(frame) {}

  // `raster` is in pixels of the full frame, `flux` a pixel's value where all of it is its own.
  void add(Vec2f raster, Color flux) const {
    for_each_pixel(raster, [&](int x, int y, float part) { frame_->add(x, y, flux * part); });
  }
  // The same with passes.
  void add(Vec2f raster, Color flux, const LightShares& shares, bool direct) const {
    for_each_pixel(
        raster, [&](int x, int y, float part) { frame_->add(x, y, flux * part, shares, direct); });
  }

 private:
  template <class F>
  void for_each_pixel(Vec2f raster, const F& f) const {
    if (frame_ == nullptr) {
      return;
    }
    const float r = filter_.radius();
    const auto first = [&](float at, int low) {
      return std::max(static_cast<int>(std::ceil(at - 0.5f - r)), low);
    };
    const auto end = [&](float at, int high) {
      return std::min(static_cast<int>(std::floor(at - 0.5f + r)) + 1, high);
    };
    const std::array<int32_t, 4>& crop = film_.crop;
    for (int y = first(raster.y, crop[1]); y < end(raster.y, crop[3]); ++y) {
      const float row = filter_.pdf_1d(raster.y - 0.5f - static_cast<float>(y));
      for (int x = first(raster.x, crop[0]); x < end(raster.x, crop[2]); ++x) {
        f(x - crop[0], y - crop[1], row * filter_.pdf_1d(raster.x - 0.5f - static_cast<float>(x)));
      }
    }
  }

  const FilmDesc& film_;
  const PixelFilter2d& filter_;
  SplatFrame* frame_;
};

}  // namespace vernier
