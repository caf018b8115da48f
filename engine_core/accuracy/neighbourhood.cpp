#include "accuracy/neighbourhood.h"

#include <algorithm>
#include <array>
#include <cstdint>

namespace vernier {
namespace {

constexpr int kNearRadius = 3;  // of the neighbourhood for variance, pixels
// A net is better than independent points by no more than this, as far as few pixels can tell.
constexpr double kLeastVariance = 0.05;

// Mean of the relative steady variances of the pixels around each.
class NearVariance {
 public:
  NearVariance(PixelEstimates pixels, std::span<const double> levels, int width, int height)
      : rows_(pixels.size()), width_(width), height_(height) {
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        Mean& mean = rows_[index(x, y)];
        for (int i = std::max(x - kNearRadius, 0); i < std::min(x + kNearRadius + 1, width); ++i) {
          const size_t from = index(i, y);
          if (known(pixels[from]) && levels[from] > 0.0) {
            mean.sum += pixels[from].steady_variance / (levels[from] * levels[from]);
            ++mean.count;
          }
        }
      }
    }
  }

  double operator()(int x, int y) const {
    Mean mean;
    for (int i = std::max(y - kNearRadius, 0); i < std::min(y + kNearRadius + 1, height_); ++i) {
      mean.sum += rows_[index(x, i)].sum, mean.count += rows_[index(x, i)].count;
    }
    return mean.count > 0 ? mean.sum / mean.count : 0.0;
  }

 private:
  struct Mean {
    double sum = 0;
    uint32_t count = 0;
  };

  size_t index(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x);
  }

  std::vector<Mean> rows_;
  int width_, height_;
};

// Sums along lines of `length` cells that are `step` apart.
std::vector<CellSums> pass(const std::vector<CellSums>& from, int radius, int step, int length) {
  std::vector<CellSums> to(from.size());
  for (size_t cell = 0; cell < from.size(); ++cell) {
    const int at = static_cast<int>(cell) / step % length;
    for (int i = std::max(-radius, -at); i <= std::min(radius, length - 1 - at); ++i) {
      to[cell].add(from[static_cast<size_t>(static_cast<int>(cell) + i * step)]);
    }
  }
  return to;
}

}  // namespace

std::vector<double> shared_excess(PixelEstimates pixels, int width, int height) {
  constexpr int kReach = 2;          // pixels: of the pixel filter
  constexpr double kContrast = 8.0;  // of an edge
  std::vector<double> result(pixels.size());
  size_t at = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x, ++at) {
      const PixelEstimate& p = pixels[at];
      if (p.excess == 0.0) {
        continue;
      }
      double brightest = 0.0;
      for (int j = std::max(y - kReach, 0); j < std::min(y + kReach + 1, height); ++j) {
        for (int i = std::max(x - kReach, 0); i < std::min(x + kReach + 1, width); ++i) {
          brightest = std::max(
              brightest, without_excess(pixels[static_cast<size_t>(j) * static_cast<size_t>(width) +
                                               static_cast<size_t>(i)]));
        }
      }
      const bool edge = p.excess <= brightest && brightest > kContrast * without_excess(p);
      result[at] = edge ? 0.0 : p.excess;
    }
  }
  return result;
}

std::vector<double> light_levels(PixelEstimates pixels, int width, int height, double least) {
  std::vector<double> own(pixels.size()), result(pixels.size());
  for (size_t i = 0; i < pixels.size(); ++i) {
    own[i] = without_excess(pixels[i]);
  }
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      std::array<double, 9> around{};
      size_t count = 0;
      for (int j = std::max(y - 1, 0); j < std::min(y + 2, height); ++j) {
        for (int i = std::max(x - 1, 0); i < std::min(x + 2, width); ++i) {
          around[count++] =
              own[static_cast<size_t>(j) * static_cast<size_t>(width) + static_cast<size_t>(i)];
        }
      }
      const auto middle = around.begin() + static_cast<ptrdiff_t>(count / 2);
      std::nth_element(around.begin(), middle, around.begin() + static_cast<ptrdiff_t>(count));
      const size_t at =
          static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x);
      result[at] = std::max(*middle, least);
    }
  }
  return result;
}

std::vector<double> pooled_variances(PixelEstimates pixels, std::span<const double> levels,
                                     int width, int height) {
  const NearVariance near(pixels, levels, width, height);
  std::vector<double> pooled(pixels.size());
  size_t i = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x, ++i) {
      pooled[i] = near(x, y) * levels[i] * levels[i];
    }
  }
  return pooled;
}

void CellSums::add(const PixelEstimate& p, double shared_excess, double pooled) {
  if (!known(p)) {
    return;
  }
  ++pixels;
  excess += shared_excess;
  excess_squared += shared_excess * shared_excess;
  // A pixel whose variance is one batch's tells nothing of the nets.
  if (std::isfinite(p.net_gap) && p.excess == 0.0 && pooled > 0.0) {
    net_gap += p.net_gap / pooled;
    variance += p.variance / pooled;
  }
}

void CellSums::add(const CellSums& c) {
  pixels += c.pixels;
  excess += c.excess, excess_squared += c.excess_squared;
  net_gap += c.net_gap, variance += c.variance;
}

double CellSums::most_lacking() const {
  return pixels > 0.0 ? (excess + std::sqrt(excess_squared)) / pixels : 0.0;
}

double CellSums::net_gain() const {
  return variance > 0.0 ? std::clamp(net_gap / variance, kLeastVariance, 1.0) : 1.0;
}

Cells::Cells(PixelEstimates pixels, std::span<const double> excess, std::span<const double> pooled,
             int width, int height)
    : columns_((width + kSide - 1) / kSide), rows_((height + kSide - 1) / kSide) {
  cells_.resize(static_cast<size_t>(columns_) * static_cast<size_t>(rows_));
  size_t i = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x, ++i) {
      cells_[index(x, y)].add(pixels[i], excess[i], pooled[i]);
    }
  }
}

std::vector<CellSums> Cells::around(int radius) const {
  return pass(pass(cells_, radius, 1, columns_), radius, columns_, rows_);
}

}  // namespace vernier
