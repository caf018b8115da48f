// Integer hashes of lattice points and floats, as Cycles' procedural textures use them
// (util/hash.h): Jenkins' lookup3 for noise, PCG (Jarzynski and Olano 2020) for cells.
#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "math/vec.h"

namespace vernier {

namespace lookup3 {
constexpr void mix(uint32_t& a, uint32_t& b, uint32_t& c) {
  a -= c, a ^= std::rotl(c, 4), c += b;
  b -= a, b ^= std::rotl(a, 6), a += c;
  c -= b, c ^= std::rotl(b, 8), b += a;
  a -= c, a ^= std::rotl(c, 16), c += b;
  b -= a, b ^= std::rotl(a, 19), a += c;
  c -= b, c ^= std::rotl(b, 4), b += a;
}
constexpr void finish(uint32_t& a, uint32_t& b, uint32_t& c) {
  c ^= b, c -= std::rotl(b, 14);
  a ^= c, a -= std::rotl(c, 11);
  b ^= a, b -= std::rotl(a, 25);
  c ^= b, c -= std::rotl(b, 16);
  a ^= c, a -= std::rotl(c, 4);
  b ^= a, b -= std::rotl(a, 14);
  c ^= b, c -= std::rotl(b, 24);
}
constexpr uint32_t seed(uint32_t words) { return 0xdeadbeefu + (words << 2) + 13u; }
}  // namespace lookup3

constexpr uint32_t hash_words(uint32_t x) {
  uint32_t a = lookup3::seed(1), b = a, c = a;
  a += x;
  lookup3::finish(a, b, c);
  return c;
}
constexpr uint32_t hash_words(uint32_t x, uint32_t y) {
  uint32_t a = lookup3::seed(2), b = a, c = a;
  a += x, b += y;
  lookup3::finish(a, b, c);
  return c;
}
constexpr uint32_t hash_words(uint32_t x, uint32_t y, uint32_t z) {
  uint32_t a = lookup3::seed(3), b = a, c = a;
  a += x, b += y, c += z;
  lookup3::finish(a, b, c);
  return c;
}
constexpr uint32_t hash_words(uint32_t x, uint32_t y, uint32_t z, uint32_t w) {
  uint32_t a = lookup3::seed(4), b = a, c = a;
  a += x, b += y, c += z;
  lookup3::mix(a, b, c);
  a += w;
  lookup3::finish(a, b, c);
  return c;
}

// The bits of floats hashed to [0, 1].
template <typename... Floats>
constexpr float hash_floats(Floats... k) {
  return static_cast<float>(hash_words(std::bit_cast<uint32_t>(static_cast<float>(k))...)) *
         (1.0f / static_cast<float>(0xffffffffu));
}

}  // namespace vernier
