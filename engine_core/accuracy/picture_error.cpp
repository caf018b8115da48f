#include "accuracy/picture_error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "accuracy/statement.h"

namespace vernier {
namespace {

constexpr int kRadius = 3;        // of a neighbourhood, pixels
constexpr int kExcessRadius = 1;  // cells
constexpr int kNetRadius = 3;     // cells
// For a percentile, and for a tile to know whether it is done: neighbourhoods overlap, so that more
// of them say the same at the price of longer looks.
constexpr double kEnoughWindows = 96 * 64;
constexpr int kLargestStride = 4;  // every tile of the film has some
constexpr int kSmoothing = 4;      // pixels

// What a pixel says of the errors around it.
struct Sample {
  float error = 0;     // the size of one, relative
  float steady = 0;    // variance of what varies steadily, relative
  float variance = 0;  // of all, relative
  bool known = false, rare = false;
};

// `level` is that around the pixel, `shared` what of its excess others have to expect.
Sample sample_of(const PixelEstimate& p, double level, double shared, double lacking,
                 double net_gain) {
  Sample s;
  s.known = known(p) && std::isfinite(p.net_gap);
  if (!s.known) {
    return s;
  }
  s.rare = p.excess > 0.0;
  // A pixel that is surely brighter than those around knows that it is.
  const double sure = without_excess(p) - std::sqrt(p.steady_variance);
  const double light = std::max(level, sure) + lacking;
  if (!(light > 0.0)) {
    return s;
  }
  const double gap = std::sqrt(p.net_gap);
  double error = std::hypot(gap, lacking) / light;
  if (s.rare) {
    error = shared > 0.0 ? std::max(gap - lacking, 0.0) / light : gap / std::max(p.mean, light);
  }
  s.error = static_cast<float>(error);
  const double lack = lacking / kNormalQuantile;
  s.steady = static_cast<float>((p.steady_variance * net_gain + lack * lack) / (light * light));
  const double own = s.rare && shared == 0.0 ? std::max(p.mean, light) : light;
  s.variance = static_cast<float>(p.variance / (own * own));
  return s;
}

// What a neighbourhood says.
struct Window {
  double half_width = std::numeric_limits<double>::infinity();
  double variance = std::numeric_limits<double>::infinity();
};

Window window(const std::vector<Sample>& samples, int x, int y, int width, int height) {
  constexpr size_t kMost = (2 * kRadius + 1) * (2 * kRadius + 1);
  std::array<float, kMost> errors;
  size_t count = 0, rare = 0;
  double steady = 0.0, variance = 0.0;
  for (int j = std::max(y - kRadius, 0); j < std::min(y + kRadius + 1, height); ++j) {
    for (int i = std::max(x - kRadius, 0); i < std::min(x + kRadius + 1, width); ++i) {
      const Sample& s =
          samples[static_cast<size_t>(j) * static_cast<size_t>(width) + static_cast<size_t>(i)];
      if (s.known) {
        errors[count++] = s.error;
        steady += static_cast<double>(s.steady), variance += static_cast<double>(s.variance);
        rare += s.rare ? 1 : 0;
      }
    }
  }
  Window w;
  if (count == 0) {
    return w;
  }
  w.variance = variance / static_cast<double>(count);
  if (rare == 0) {
    w.half_width = kNormalQuantile * std::sqrt(steady / static_cast<double>(count));
    return w;
  }
  const auto rank = static_cast<ptrdiff_t>(kConfidence * static_cast<double>(count));
  const auto end = errors.begin() + static_cast<ptrdiff_t>(count);
  const auto at = std::min(errors.begin() + rank, end - 1);
  std::nth_element(errors.begin(), at, end);
  w.half_width = static_cast<double>(*at);
  return w;
}

// The median of the known neighbourhoods around each that is known: the 95th percentile of many
// uncertain percentiles would be that of the unluckiest guess, and where a few pixels more than
// others met a rare path by chance, one guess is off by far.
std::vector<float> smoothed(const PictureErrors& p) {
  constexpr size_t kMost = (2 * kSmoothing + 1) * (2 * kSmoothing + 1);
  const int radius = kSmoothing / p.stride;
  std::vector<float> result(p.errors);
  std::array<float, kMost> around;
  size_t at = 0;
  for (int y = 0; y < p.rows; ++y) {
    for (int x = 0; x < p.columns; ++x, ++at) {
      if (!std::isfinite(p.errors[at])) {
        continue;
      }
      size_t count = 0;
      for (int j = std::max(y - radius, 0); j < std::min(y + radius + 1, p.rows); ++j) {
        for (int i = std::max(x - radius, 0); i < std::min(x + radius + 1, p.columns); ++i) {
          const float error = p.errors[static_cast<size_t>(j) * static_cast<size_t>(p.columns) +
                                       static_cast<size_t>(i)];
          if (std::isfinite(error)) {
            around[count++] = error;
          }
        }
      }
      const auto middle = around.begin() + static_cast<ptrdiff_t>(count / 2);
      std::nth_element(around.begin(), middle, around.begin() + static_cast<ptrdiff_t>(count));
      result[at] = *middle;
    }
  }
  return result;
}

}  // namespace

PictureErrors picture_errors(PixelEstimates pixels, int width, int height, double mean) {
  const double least = kErrorFloor * std::abs(mean);
  const std::vector<double> levels = light_levels(pixels, width, height, least);
  const std::vector<double> pooled = pooled_variances(pixels, levels, width, height);
  const std::vector<double> shared = shared_excess(pixels, width, height);
  const Cells cells(pixels, shared, pooled, width, height);
  const std::vector<CellSums> nets = cells.around(kNetRadius);
  const std::vector<CellSums> excess = cells.around(kExcessRadius);
  std::vector<Sample> samples(pixels.size());
  size_t at = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x, ++at) {
      const size_t cell = cells.index(x, y);
      samples[at] = sample_of(pixels[at], levels[at], shared[at], excess[cell].lacking(),
                              nets[cell].net_gain());
    }
  }
  PictureErrors result;
  result.stride = std::clamp(
      static_cast<int>(std::ceil(std::sqrt(static_cast<double>(pixels.size()) / kEnoughWindows))),
      1, kLargestStride);
  result.columns = (width + result.stride - 1) / result.stride;
  result.rows = (height + result.stride - 1) / result.stride;
  result.errors.reserve(static_cast<size_t>(result.columns) * static_cast<size_t>(result.rows));
  for (int y = 0; y < height; y += result.stride) {
    for (int x = 0; x < width; x += result.stride) {
      const Window w = window(samples, x, y, width, height);
      result.errors.push_back(static_cast<float>(w.half_width));
      result.variances.push_back(static_cast<float>(w.variance));
    }
  }
  result.errors = smoothed(result);
  return result;
}

}  // namespace vernier
