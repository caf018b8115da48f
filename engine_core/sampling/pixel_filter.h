// Importance sampling of the pixel filter.
#pragma once

#include <array>

#include "math/vec.h"
#include "scene/description.h"

namespace vernier {

// A separable filter, sampled exactly in proportion to its value: every sample has weight 1
// (Ernst, Stamminger and Greiner 2006, "Filter Importance Sampling").
class PixelFilter2d {
 public:
  // `width` is the full width in pixels.
  PixelFilter2d(FilterKind kind, float width);

  // Offset from the pixel's centre, pixels.
  Vec2f sample(Vec2f u) const { return {sample_1d(u.x), sample_1d(u.y)}; }

 private:
  static constexpr int kCells = 256;

  // Piecewise linear inverse of the distribution function.
  float sample_1d(float u) const {
    const float x = u * kCells;
    const auto i = static_cast<size_t>(std::min(static_cast<int>(x), kCells - 1));
    return lerp(inverse_[i], inverse_[i + 1], x - static_cast<float>(i));
  }

  std::array<float, kCells + 1> inverse_;
};

}  // namespace vernier
