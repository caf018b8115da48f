#include "math/distribution.h"

#include <algorithm>
#include <cmath>

#include "math/rng.h"

namespace vernier {
namespace {

// Writes the n + 1 values of the distribution function of n weights; returns their sum.
double build_cdf(std::span<const float> weights, std::span<float> cdf) {
  const size_t n = weights.size();
  double total = 0.0;
  for (const float w : weights) {
    total += static_cast<double>(w);
  }
  double sum = 0.0;
  for (size_t i = 0; i < n; ++i) {
    cdf[i] = static_cast<float>(total > 0.0 ? sum / total
                                            : static_cast<double>(i) / static_cast<double>(n));
    sum += static_cast<double>(weights[i]);
  }
  cdf[n] = 1.0f;
  return total;
}

// The cell i with cdf[i] <= u < cdf[i + 1]; it is never empty.
size_t find_cell(std::span<const float> cdf, float u) {
  const auto above = std::upper_bound(cdf.begin(), cdf.end(), std::min(u, kOneMinusEpsilon));
  return static_cast<size_t>(above - cdf.begin()) - 1u;
}

// The point of cell i at which the distribution function is u.
float sample_cdf(std::span<const float> cdf, float u, size_t i, float& pdf) {
  const float width = cdf[i + 1] - cdf[i];
  const auto n = static_cast<float>(cdf.size() - 1);
  pdf = width * n;
  return std::min((static_cast<float>(i) + (u - cdf[i]) / width) / n, kOneMinusEpsilon);
}

size_t cell_at(float x, size_t n) {
  const auto i = static_cast<size_t>(std::max(x, 0.0f) * static_cast<float>(n));
  return std::min(i, n - 1);
}

float pdf_cdf(std::span<const float> cdf, float x) {
  const size_t n = cdf.size() - 1;
  const size_t i = cell_at(x, n);
  return (cdf[i + 1] - cdf[i]) * static_cast<float>(n);
}

}  // namespace

double extend_bits(float u) {
  // By signed numbers, for which there are instructions on all processors.
  const auto bits = static_cast<int64_t>(static_cast<double>(u) * 0x1p32);
  const auto more = static_cast<int64_t>(hash64(static_cast<uint64_t>(bits)) >> 43);
  return static_cast<double>((bits << 21) + more) * 0x1p-53;  // 53 bits in all
}

PiecewiseConstant1D::PiecewiseConstant1D(std::span<const float> weights)
    : cdf_(weights.size() + 1) {
  build_cdf(weights, cdf_);
}

float PiecewiseConstant1D::sample(float u, float& pdf, uint32_t& cell) const {
  const size_t i = find_cell(cdf_, u);
  cell = static_cast<uint32_t>(i);
  return sample_cdf(cdf_, u, i, pdf);
}

float PiecewiseConstant1D::pdf(float x) const { return pdf_cdf(cdf_, x); }

PiecewiseConstant2D::PiecewiseConstant2D(std::span<const float> weights, int width, int height)
    : width_(width) {
  const auto w = static_cast<size_t>(width);
  const auto h = static_cast<size_t>(height);
  rows_.resize((w + 1) * h);
  std::vector<double> sums(h);
  double largest = 0.0;
  for (size_t y = 0; y < h; ++y) {
    sums[y] = build_cdf(weights.subspan(y * w, w), std::span(rows_).subspan(y * (w + 1), w + 1));
    largest = std::max(largest, sums[y]);
  }
  // Row sums may exceed float32: relative to the largest they do not.
  std::vector<float> relative(h);
  for (size_t y = 0; y < h; ++y) {
    relative[y] = largest > 0.0 ? static_cast<float>(sums[y] / largest) : 0.0f;
  }
  marginal_ = PiecewiseConstant1D(relative);
}

Vec2f PiecewiseConstant2D::sample(Vec2f u, float& pdf) const {
  const auto w = static_cast<size_t>(width_);
  float pdf_row, pdf_x;
  uint32_t row;
  const float y = marginal_.sample(u.y, pdf_row, row);
  const std::span<const float> cdf = std::span(rows_).subspan(row * (w + 1), w + 1);
  const float x = sample_cdf(cdf, u.x, find_cell(cdf, u.x), pdf_x);
  pdf = pdf_row * pdf_x;
  return {x, y};
}

float PiecewiseConstant2D::pdf(Vec2f p) const {
  const auto w = static_cast<size_t>(width_);
  const size_t row = cell_at(p.y, marginal_.size());
  return marginal_.pdf(p.y) * pdf_cdf(std::span(rows_).subspan(row * (w + 1), w + 1), p.x);
}

AliasTable::AliasTable(std::span<const double> weights) {
  double total = 0.0;
  for (const double w : weights) {
    total += w;
  }
  if (!(total > 0.0)) {
    return;
  }
  const size_t n = weights.size();
  bins_.resize(n);
  std::vector<double> share(n);  // of the average weight
  std::vector<uint32_t> poor, rich;
  for (size_t i = 0; i < n; ++i) {
    const double probability = weights[i] / total;
    bins_[i].probability = static_cast<float>(probability);
    bins_[i].alias = static_cast<uint32_t>(i);
    share[i] = probability * static_cast<double>(n);
    (share[i] < 1.0 ? poor : rich).push_back(static_cast<uint32_t>(i));
  }
  while (!poor.empty() && !rich.empty()) {
    const uint32_t taker = poor.back();
    const uint32_t giver = rich.back();
    poor.pop_back();
    bins_[taker].threshold = static_cast<float>(share[taker]);
    bins_[taker].alias = giver;
    share[giver] -= 1.0 - share[taker];
    if (share[giver] < 1.0) {
      rich.pop_back();
      poor.push_back(giver);
    }
  }
  // What is left on either side is 1 but for rounding, except an item of weight 0 that found no
  // giver: it must not be chosen.
  for (const uint32_t i : poor) {
    if (weights[i] == 0.0) {
      bins_[i].threshold = 0.0f;
      bins_[i].alias =
          static_cast<uint32_t>(std::max_element(weights.begin(), weights.end()) - weights.begin());
    }
  }
}

uint32_t AliasTable::sample(float u) const {
  const double x = extend_bits(u) * static_cast<double>(bins_.size());
  const auto i = std::min(static_cast<size_t>(x), bins_.size() - 1);
  return x - static_cast<double>(i) < static_cast<double>(bins_[i].threshold)
             ? static_cast<uint32_t>(i)
             : bins_[i].alias;
}

}  // namespace vernier
