#include "sampling/pixel_filter.h"

#include <numbers>

namespace vernier {
namespace {

// Filter shapes as Cycles has them (scene/film.cpp): the Gaussian is exp(-2 (6 x)^2).
// x in [-1/2, 1/2] of the full extent.
double shape(FilterKind kind, double x) {
  switch (kind) {
    case FilterKind::kBox:
      return 1.0;
    case FilterKind::kGaussian:
      return std::exp(-72.0 * x * x);
    case FilterKind::kBlackmanHarris: {
      const double v = 2.0 * std::numbers::pi * (x + 0.5);
      return 0.35875 - 0.48829 * std::cos(v) + 0.14128 * std::cos(2 * v) -
             0.01168 * std::cos(3 * v);
    }
  }
  return 0.0;
}

// The full extent in units of the width that Blender names (scene/film.cpp).
float extent(FilterKind kind) {
  switch (kind) {
    case FilterKind::kBox:
      return 1.0f;
    case FilterKind::kGaussian:
      return 3.0f;
    case FilterKind::kBlackmanHarris:
      return 2.0f;
  }
  return 1.0f;
}

}  // namespace

PixelFilter2d::PixelFilter2d(FilterKind kind, float width) : extent_(width * extent(kind)) {
  // Cell integrals by the midpoint rule.
  constexpr int kSteps = 32;
  std::array<double, kCells + 1> sum{};
  for (size_t cell = 0; cell < kCells; ++cell) {
    sum[cell + 1] = sum[cell];
    for (int i = 0; i < kSteps; ++i) {
      const double x = (static_cast<double>(cell) + (i + 0.5) / kSteps) / kCells - 0.5;
      sum[cell + 1] += shape(kind, x);
    }
  }
  for (size_t i = 0; i <= kCells; ++i) {
    cdf_[i] = static_cast<float>(sum[i] / sum[kCells]);
  }
  size_t cell = 0;
  for (size_t i = 0; i < kGuides; ++i) {
    while (cdf_[cell + 1] <= static_cast<float>(i) / kGuides) {
      ++cell;
    }
    guide_[i] = static_cast<uint8_t>(cell);
  }
}

}  // namespace vernier
