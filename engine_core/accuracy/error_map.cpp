#include "accuracy/error_map.h"

#include <array>

#include "accuracy/statement.h"

namespace vernier {
namespace {

// The normal distribution's 97.5 % quantile: pooled variances have many degrees of freedom.
constexpr double kQuantile = 1.959963984540054;
constexpr int kNearRadius = 3;  // of the neighbourhood for variance, pixels
constexpr double kOwnShare = 0.5;

// Wider neighbourhoods are made of square cells.
constexpr int kCell = 8;                      // pixels
constexpr int kNetRadius = 3;                 // cells
constexpr std::array kExcessRadii{1, 3, 12};  // cells
// A net is better than independent points by no more than this, as far as few pixels can tell.
constexpr double kLeastVariance = 0.05;

using Pixels = std::span<const PixelEstimate>;

bool known(const PixelEstimate& p) { return std::isfinite(p.variance); }

double without_excess(const PixelEstimate& p) { return known(p) ? p.mean - p.excess : 0.0; }

// The excess that other pixels have to expect, too. Beside the edge of something far brighter a
// single batch may well see it: that is where it is, and not elsewhere.
std::vector<double> shared_excess(Pixels pixels, int width, int height) {
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

// The median around each pixel of what pixels would be without their excess; no less than `least`.
// Variances are pooled relative to its square: beside the edge of a lamp, dark pixels know that
// they are not as uncertain as those which the edge passes.
std::vector<double> levels(Pixels pixels, int width, int height, double least) {
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

// Mean of the relative steady variances of the pixels around each.
class NearVariance {
 public:
  NearVariance(Pixels pixels, std::span<const double> levels, int width, int height)
      : rows_(pixels.size()), width_(width), height_(height) {
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        Mean& mean = rows_[index(x, y)];
        for (int i = std::max(x - kNearRadius, 0); i < std::min(x + kNearRadius + 1, width); ++i) {
          const size_t from = index(i, y);
          if (known(pixels[from])) {
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

// Sums over the pixels of a cell, or of several.
struct CellSums {
  double pixels = 0;
  double excess = 0, excess_squared = 0;
  double net_gap = 0, variance = 0;  // relative to what is pooled nearby, so that all count alike

  // `pooled`: the variance to expect of the pixel.
  void add(const PixelEstimate& p, double shared_excess, double pooled) {
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
  void add(const CellSums& c) {
    pixels += c.pixels;
    excess += c.excess, excess_squared += c.excess_squared;
    net_gap += c.net_gap, variance += c.variance;
  }
  // What a pixel lacks that has met none of the rare paths of those counted here.
  double lacking() const {
    return pixels > 0.0 ? (excess + std::sqrt(excess_squared)) / pixels : 0.0;
  }
  double net_gain() const {
    return variance > 0.0 ? std::clamp(net_gap / variance, kLeastVariance, 1.0) : 1.0;
  }
};

// A grid of cells over the picture.
class Cells {
 public:
  Cells(Pixels pixels, std::span<const double> excess, std::span<const double> pooled, int width,
        int height)
      : columns_((width + kCell - 1) / kCell), rows_((height + kCell - 1) / kCell) {
    cells_.resize(static_cast<size_t>(columns_) * static_cast<size_t>(rows_));
    size_t i = 0;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x, ++i) {
        cells_[index(x, y)].add(pixels[i], excess[i], pooled[i]);
      }
    }
  }

  // The cell of a pixel.
  size_t index(int x, int y) const {
    return static_cast<size_t>(y / kCell) * static_cast<size_t>(columns_) +
           static_cast<size_t>(x / kCell);
  }

  // For every cell: the sums over the square of cells around it.
  std::vector<CellSums> around(int radius) const {
    return pass(pass(cells_, radius, 1, columns_), radius, columns_, rows_);
  }

 private:
  // Sums along lines of `length` cells that are `step` apart.
  static std::vector<CellSums> pass(const std::vector<CellSums>& from, int radius, int step,
                                    int length) {
    std::vector<CellSums> to(from.size());
    for (size_t cell = 0; cell < from.size(); ++cell) {
      const int at = static_cast<int>(cell) / step % length;
      for (int i = std::max(-radius, -at); i <= std::min(radius, length - 1 - at); ++i) {
        to[cell].add(from[static_cast<size_t>(static_cast<int>(cell) + i * step)]);
      }
    }
    return to;
  }

  int columns_, rows_;
  std::vector<CellSums> cells_;
};

}  // namespace

std::vector<float> half_widths(Pixels pixels, int width, int height, double mean) {
  const std::vector<double> level = levels(pixels, width, height, kErrorFloor * std::abs(mean));
  const NearVariance near(pixels, level, width, height);
  std::vector<double> pooled(pixels.size());
  size_t i = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x, ++i) {
      pooled[i] = near(x, y) * level[i] * level[i];
    }
  }
  const Cells cells(pixels, shared_excess(pixels, width, height), pooled, width, height);
  const std::vector<CellSums> nets = cells.around(kNetRadius);
  std::array<std::vector<CellSums>, kExcessRadii.size()> excesses;
  for (size_t k = 0; k < kExcessRadii.size(); ++k) {
    excesses[k] = cells.around(kExcessRadii[k]);
  }
  std::vector<float> widths(pixels.size());
  i = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x, ++i) {
      const size_t cell = cells.index(x, y);
      double lacking = 0.0;
      for (const std::vector<CellSums>& sums : excesses) {
        lacking = std::max(lacking, sums[cell].lacking());
      }
      const double variance = kOwnShare * pixels[i].variance + (1.0 - kOwnShare) * pooled[i];
      const double random = kQuantile * std::sqrt(variance * nets[cell].net_gain());
      // What is lacking is the same every time: it shifts what varies.
      widths[i] = static_cast<float>(random + lacking);
    }
  }
  return widths;
}

}  // namespace vernier
