// What the pixels around a pixel tell of it: the light there is, how uncertain it is, what single
// batches brought beyond all others, and what the nets' regular spacing gains.
#pragma once

#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "accuracy/pixel_sums.h"

namespace vernier {

using PixelEstimates = std::span<const PixelEstimate>;

// The normal distribution's 97.5 % quantile: pooled variances have many degrees of freedom.
inline constexpr double kNormalQuantile = 1.959963984540054;

inline bool known(const PixelEstimate& p) { return std::isfinite(p.variance); }

// The light without what a single batch brought beyond all others.
inline double without_excess(const PixelEstimate& p) { return known(p) ? p.mean - p.excess : 0.0; }

// The excess that other pixels have to expect, too, by pixel. Beside the edge of something far
// brighter a single batch may well see it: that is where it is, and not elsewhere.
std::vector<double> shared_excess(PixelEstimates pixels, int width, int height);

// The median of the 3 x 3 pixels around each, without their excess; no less than `least`. Variances
// are pooled relative to its square: beside the edge of a lamp, dark pixels know that they are not
// as uncertain as those which the edge passes.
std::vector<double> light_levels(PixelEstimates pixels, int width, int height, double least);

// The mean of the steady variances, each relative to its level squared, of the 7 x 7 pixels around
// each, times its own level squared.
std::vector<double> pooled_variances(PixelEstimates pixels, std::span<const double> levels,
                                     int width, int height);

// Sums over the pixels of a cell, or of several.
struct CellSums {
  double pixels = 0;
  double excess = 0, excess_squared = 0;
  double net_gap = 0, variance = 0;  // relative to what is pooled nearby, so that all count alike

  // `pooled`: the variance to expect of the pixel.
  void add(const PixelEstimate& p, double shared_excess, double pooled);
  void add(const CellSums& c);
  // The mean excess: what a pixel that has met none of the rare paths counted here lacks.
  double lacking() const { return pixels > 0.0 ? excess / pixels : 0.0; }
  // That and its own standard error.
  double most_lacking() const;
  // How much better the nets' mean is than the spread of their batches tells, as a ratio of
  // variances.
  double net_gain() const;
};

// A grid of square cells over the picture.
class Cells {
 public:
  static constexpr int kSide = 8;  // pixels

  // `excess` is shared_excess(), `pooled` pooled_variances().
  Cells(PixelEstimates pixels, std::span<const double> excess, std::span<const double> pooled,
        int width, int height);

  // The cell of a pixel.
  size_t index(int x, int y) const {
    return static_cast<size_t>(y / kSide) * static_cast<size_t>(columns_) +
           static_cast<size_t>(x / kSide);
  }

  // For every cell: the sums over the square of cells around it, `radius` to each side.
  std::vector<CellSums> around(int radius) const;

 private:
  int columns_, rows_;
  std::vector<CellSums> cells_;
};

}  // namespace vernier
