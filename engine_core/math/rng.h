// Hashes and a small random number generator, for where no stratification is wanted.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "math/vec.h"

namespace vernier {

// Finaliser of 64 bits to 64 (SplitMix64; Steele, Lea and Flood 2014).
constexpr uint64_t hash64(uint64_t x) {
  x += 0x9e3779b97f4a7c15ull;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}

// The float32 in [0, 1) whose fixed-point expansion is the 24 highest bits of x.
constexpr float to_unit_float(uint32_t x) { return static_cast<float>(x >> 8) * 0x1p-24f; }

// PCG32 (O'Neill 2014): 64 bits of state, a stream per `sequence`.
class Pcg32 {
 public:
  explicit Pcg32(uint64_t seed, uint64_t sequence = 0) : increment_((sequence << 1) | 1u) {
    next();
    state_ += hash64(seed);
    next();
  }
  uint32_t next() {
    const uint64_t old = state_;
    state_ = old * 6364136223846793005ull + increment_;
    const auto shifted = static_cast<uint32_t>(((old >> 18u) ^ old) >> 27u);
    const auto rotation = static_cast<uint32_t>(old >> 59u);
    return (shifted >> rotation) | (shifted << ((32u - rotation) & 31u));
  }
  float next_float() { return to_unit_float(next()); }

 private:
  uint64_t state_ = 0;
  uint64_t increment_;
};

// The i-th of many uniform numbers made from one in [0,1): each is uniform by itself. Multiples of
// the golden ratio turn it on (0x9e3779b9 is 2^32 over that), which keeps any few in a row apart
// (Weyl's sequence).
inline float rotate(float u, uint32_t i) {
  const float turned = u + static_cast<float>(i * 0x9e3779b9u >> 8) * 0x1p-24f;
  return std::min(turned - std::floor(turned), 0x1.fffffep-1f);
}

}  // namespace vernier
