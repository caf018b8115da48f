// Integer hashes of lattice points and floats, as Cycles' procedural textures use them
// (util/hash.h): Jenkins' lookup3 for noise, PCG (Jarzynski and Olano 2020) for cells.
#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "math/vec.h"

namespace vernier {

// A word is a uint32_t, or a vector of them that is hashed lane by lane.
namespace lookup3 {
template <typename Word>
constexpr Word rotl(Word x, int k) {
  return x << k | x >> (32 - k);
}
template <typename Word>
constexpr void mix(Word& a, Word& b, Word& c) {
  a -= c, a ^= rotl(c, 4), c += b;
  b -= a, b ^= rotl(a, 6), a += c;
  c -= b, c ^= rotl(b, 8), b += a;
  a -= c, a ^= rotl(c, 16), c += b;
  b -= a, b ^= rotl(a, 19), a += c;
  c -= b, c ^= rotl(b, 4), b += a;
}
template <typename Word>
constexpr void finish(Word& a, Word& b, Word& c) {
  c ^= b, c -= rotl(b, 14);
  a ^= c, a -= rotl(c, 11);
  b ^= a, b -= rotl(a, 25);
  c ^= b, c -= rotl(b, 16);
  a ^= c, a -= rotl(c, 4);
  b ^= a, b -= rotl(a, 14);
  c ^= b, c -= rotl(b, 24);
}
constexpr uint32_t seed(uint32_t words) { return 0xdeadbeefu + (words << 2) + 13u; }
}  // namespace lookup3

template <typename Word>
constexpr Word hash_words(Word x) {
  Word a = x + lookup3::seed(1), b = Word{} + lookup3::seed(1), c = b;
  lookup3::finish(a, b, c);
  return c;
}
template <typename Word>
constexpr Word hash_words(Word x, Word y) {
  Word a = x + lookup3::seed(2), b = y + lookup3::seed(2), c = Word{} + lookup3::seed(2);
  lookup3::finish(a, b, c);
  return c;
}
template <typename Word>
constexpr Word hash_words(Word x, Word y, Word z) {
  Word a = x + lookup3::seed(3), b = y + lookup3::seed(3), c = z + lookup3::seed(3);
  lookup3::finish(a, b, c);
  return c;
}
template <typename Word>
constexpr Word hash_words(Word x, Word y, Word z, Word w) {
  Word a = x + lookup3::seed(4), b = y + lookup3::seed(4), c = z + lookup3::seed(4);
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
