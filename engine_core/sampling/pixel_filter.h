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
  // `width` in pixels as Blender names it: a box's extent, a third of a Gaussian's, half of a
  // Blackman-Harris window's.
  PixelFilter2d(FilterKind kind, float width);

  // Offset from the pixel's centre, pixels.
  Vec2f sample(Vec2f u) const { return {sample_1d(u.x), sample_1d(u.y)}; }
  // Density of an offset along one axis, per pixel: the filter is the product of both axes'.
  float pdf_1d(float offset) const {
    const float x = (offset / extent_ + 0.5f) * kCells;
    if (!(x >= 0.0f && x < kCells)) {
      return 0.0f;
    }
    const auto cell = static_cast<size_t>(x);
    return (cdf_[cell + 1] - cdf_[cell]) * (kCells / extent_);
  }
  // The largest offset along an axis, pixels.
  float radius() const { return 0.5f * extent_; }

 private:
  static constexpr int kCells = 128;  // of even width: the density is constant in each
  static constexpr int kGuides = 1024;

  float sample_1d(float u) const {
    size_t cell = guide_[static_cast<size_t>(u * kGuides)];
    while (cdf_[cell + 1] <= u) {
      ++cell;
    }
    const float within = (u - cdf_[cell]) / (cdf_[cell + 1] - cdf_[cell]);
    return ((static_cast<float>(cell) + within) * (1.0f / kCells) - 0.5f) * extent_;
  }

  float extent_;  // pixels
  std::array<float, kCells + 1> cdf_;
  // The cell of u = i / kGuides, where the search begins: hardly ever more than one before its end.
  std::array<uint8_t, kGuides> guide_;
};

}  // namespace vernier
