// Tabulated distributions: piecewise-constant densities on [0,1) and [0,1)^2, and discrete choices.
//
// A density is always that of the table as stored, so that samples and densities agree however the
// weights round: a weight too small to show in float32 beside its neighbours gets density 0.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "math/vec.h"

namespace vernier {

// u in [0,1) continued beyond its 24 bits by a hash of them, for where many choices in a row are
// made with one number.
double extend_bits(float u);

// A density on [0,1) that is constant on each of n equal cells.
class PiecewiseConstant1D {
 public:
  PiecewiseConstant1D() = default;
  // Weights are finite and non-negative, not necessarily normalised. All zero: uniform.
  explicit PiecewiseConstant1D(std::span<const float> weights);

  uint32_t size() const { return static_cast<uint32_t>(cdf_.size()) - 1u; }
  // The point at which the distribution function is u, the density there and the cell it is in.
  float sample(float u, float& pdf, uint32_t& cell) const;
  // Density at x in [0,1).
  float pdf(float x) const;

 private:
  std::vector<float> cdf_;  // n + 1 values from 0 to 1
};

// A density on the unit square that is constant on each cell of a grid.
class PiecewiseConstant2D {
 public:
  PiecewiseConstant2D() = default;
  // `weights` in rows of `width`; row 0 is at y = 0. Finite and non-negative; all zero: uniform.
  PiecewiseConstant2D(std::span<const float> weights, int width, int height);

  Vec2f sample(Vec2f u, float& pdf) const;
  float pdf(Vec2f p) const;

 private:
  int width_ = 0;
  std::vector<float> rows_;  // width + 1 values per row
  PiecewiseConstant1D marginal_;
};

// A choice among n items in constant time (Walker 1977; built as in Vose 1991).
class AliasTable {
 public:
  AliasTable() = default;
  // Weights are finite and non-negative. All zero, or none: an empty table.
  explicit AliasTable(std::span<const double> weights);

  uint32_t size() const { return static_cast<uint32_t>(bins_.size()); }
  // The item chosen by u in [0,1); the table may not be empty.
  uint32_t sample(float u) const;
  // Probability of item i; 0 in an empty table.
  float probability(uint32_t i) const { return i < bins_.size() ? bins_[i].probability : 0.0f; }

 private:
  struct Bin {
    float threshold = 1;  // part of the bin that stays with its own item
    uint32_t alias = 0;
    float probability = 0;
  };
  std::vector<Bin> bins_;
};

}  // namespace vernier
