#include "sampling/pixel_filter.h"

#include <numbers>
#include <vector>

namespace vernier {
namespace {

// Filter shapes as Cycles has them (scene/film.cpp): the Gaussian is exp(-2 (6 x)^2).
// x in [-1/2, 1/2] of the full width.
double shape(FilterKind kind, double x) {
  switch (kind) {
    case FilterKind::kBox: return 1.0;
    case FilterKind::kGaussian: return std::exp(-72.0 * x * x);
    case FilterKind::kBlackmanHarris: {
      const double v = 2.0 * std::numbers::pi * (x + 0.5);
      return 0.35875 - 0.48829 * std::cos(v) + 0.14128 * std::cos(2 * v) -
             0.01168 * std::cos(3 * v);
    }
  }
  return 0.0;
}

}  // namespace

PixelFilter2d::PixelFilter2d(FilterKind kind, float width) {
  // The distribution function by the trapezoidal rule, inverted at even steps.
  constexpr int kSteps = 1 << 14;
  std::vector<double> cdf(kSteps + 1, 0.0);
  for (int i = 1; i <= kSteps; ++i) {
    const double a = static_cast<double>(i - 1) / kSteps - 0.5;
    const double b = static_cast<double>(i) / kSteps - 0.5;
    cdf[static_cast<size_t>(i)] =
        cdf[static_cast<size_t>(i - 1)] + 0.5 * (shape(kind, a) + shape(kind, b));
  }
  const double total = cdf.back();
  size_t step = 0;
  for (size_t i = 0; i <= static_cast<size_t>(kCells); ++i) {
    const double target = total * static_cast<double>(i) / kCells;
    while (step < static_cast<size_t>(kSteps) && cdf[step + 1] < target) {
      ++step;
    }
    const size_t next = std::min(step + 1, static_cast<size_t>(kSteps));
    const double rise = cdf[next] - cdf[step];
    const double part = rise > 0.0 ? (target - cdf[step]) / rise : 0.0;
    const double x = (static_cast<double>(step) + part) / kSteps - 0.5;
    inverse_[i] = static_cast<float>(x * static_cast<double>(width));
  }
}

}  // namespace vernier
