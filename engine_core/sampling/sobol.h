// Owen-scrambled Sobol points whose error is distributed as blue noise over the frame.
//
// One two-dimensional Sobol (0,2)-sequence serves every dimension pair. The samples of a render are
// numbered along a Morton curve of pixels, each pixel owning a run of 2^k consecutive numbers, and
// each dimension pair visits the sequence in its own nested-uniform shuffle of these numbers. Any
// aligned square of 4^j pixels then shares one stratified block, which moves the error to high
// spatial frequencies (Ahmed and Wonka 2020, "Screen-Space Blue-Noise Diffusion of Monte Carlo
// Sampling Error via Hierarchical Ordering of Pixels"). Scrambling and shuffling use a hash
// (Laine and Karras 2011; Burley 2020, "Practical Hash-based Owen Scrambling").
#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "math/rng.h"
#include "math/vec.h"

namespace vernier {

constexpr uint32_t reverse_bits(uint32_t x) {
#if defined(__clang__)
  return __builtin_bitreverse32(x);
#else
  x = __builtin_bswap32(x);
  x = ((x & 0x0f0f0f0fu) << 4) | ((x >> 4) & 0x0f0f0f0fu);
  x = ((x & 0x33333333u) << 2) | ((x >> 2) & 0x33333333u);
  x = ((x & 0x55555555u) << 1) | ((x >> 1) & 0x55555555u);
  return x;
#endif
}

// Owen scrambling of the bits of x in reversed order: each bit is flipped by a hash of the lower
// ones. Constants: Vegdahl 2021, "Building a Better LK Hash".
constexpr uint32_t laine_karras(uint32_t x, uint32_t seed) {
  x ^= x * 0x3d20adeau;
  x += seed;
  x *= (seed >> 16) | 1u;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  return x;
}

// Product with Pascal's triangle modulo 2: the second Sobol dimension's generator matrix, in
// reversed bit order, by its self-similarity.
constexpr uint32_t pascal_product(uint32_t x) {
  x ^= (x & 0xffff0000u) >> 16;
  x ^= (x & 0xff00ff00u) >> 8;
  x ^= (x & 0xf0f0f0f0u) >> 4;
  x ^= (x & 0xccccccccu) >> 2;
  x ^= (x & 0xaaaaaaaau) >> 1;
  return x;
}

// Interleaves the low 16 bits of x and y.
constexpr uint32_t morton(uint32_t x, uint32_t y) {
  const auto spread = [](uint32_t v) {
    v &= 0xffffu;
    v = (v | (v << 8)) & 0x00ff00ffu;
    v = (v | (v << 4)) & 0x0f0f0f0fu;
    v = (v | (v << 2)) & 0x33333333u;
    return (v | (v << 1)) & 0x55555555u;
  };
  return spread(x) | (spread(y) << 1);
}

class SobolSampler {
 public:
  // Sample `index` (below 2^log2_samples) of a pixel. Equal arguments give equal points; renders
  // with different seeds are independent.
  SobolSampler(uint32_t x, uint32_t y, uint32_t index, int log2_samples, uint64_t seed) {
    // Pixels beyond the square that 32 bits can number get a sequence of their own.
    const int side = (32 - log2_samples) / 2;
    const uint32_t low = side >= 16 ? 0xffffu : (1u << side) - 1u;
    const uint64_t tile = (static_cast<uint64_t>(x & ~low) << 32) | (y & ~low);
    seed_ = hash64(seed ^ hash64(tile));
    const uint32_t number = (morton(x & low, y & low) << log2_samples) | index;
    reversed_ = reverse_bits(number);
  }

  // The same sample's number in an independent sequence: one for every pair (a, b).
  SobolSampler another(uint64_t a, uint64_t b) const {
    SobolSampler result = *this;
    result.seed_ = hash64(hash64(seed_ ^ (a << 32)) + b);
    return result;
  }

  // A point of [0,1)^2 for the dimension pair.
  Vec2f get_2d(uint32_t dimension) const { return get_2d_run<1>(dimension)[0]; }

  // The points of `kCount` dimension pairs from `first` on. Four together cost little more than
  // one alone: the loops become vector instructions (as long as the function stays one).
  template <uint32_t kCount>
  [[gnu::noinline]] std::array<Vec2f, kCount> get_2d_run(uint32_t first) const {
    // Numbers in the sequence, and seeds of the scrambling: all x, then all y.
    std::array<uint32_t, 2 * kCount> number, scramble;
    std::array<uint32_t, kCount> shuffle;
    for (uint32_t i = 0; i < kCount; ++i) {
      const uint64_t h = hash64(seed_ + first + i);
      shuffle[i] = static_cast<uint32_t>(h);
      scramble[i] = static_cast<uint32_t>(h >> 32);
    }
    for (uint32_t i = 0; i < kCount; ++i) {
      number[i] = reverse_bits(laine_karras(reversed_, shuffle[i]));
      number[kCount + i] = pascal_product(number[i]);
      scramble[kCount + i] = scramble[i] * 0x9e3779b1u + 0x7f4a7c15u;
    }
    std::array<float, 2 * kCount> value;
    for (uint32_t i = 0; i < 2 * kCount; ++i) {
      value[i] = to_unit_float(reverse_bits(laine_karras(number[i], scramble[i])));
    }
    std::array<Vec2f, kCount> points;
    for (uint32_t i = 0; i < kCount; ++i) {
      points[i] = {value[i], value[kCount + i]};
    }
    return points;
  }

 private:
  uint64_t seed_;
  uint32_t reversed_;  // bits of the sample's number, reversed
};

}  // namespace vernier
