// Vectors as wide as the processor's registers, by the compilers' vector extensions: operators work
// on the lanes side by side, and comparisons give -1 where they hold and 0 elsewhere.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

namespace vernier {

template <typename T, int kLanes>
struct LanesOf {
  using Type [[gnu::vector_size(sizeof(T) * kLanes)]] = T;
};
template <typename T, int kLanes>
using Lanes = typename LanesOf<T, kLanes>::Type;

using Floats4 = Lanes<float, 4>;
using Ints4 = Lanes<int32_t, 4>;

#ifdef __AVX2__
inline constexpr int kWideLanes = 8;
#else
inline constexpr int kWideLanes = 4;
#endif
using WideFloats = Lanes<float, kWideLanes>;
using WideInts = Lanes<int32_t, kWideLanes>;
using WideWords = Lanes<uint32_t, kWideLanes>;

// The parts of a wide vector, of four lanes each: which one a lane belongs to, the vector all of
// whose parts are `v`, and one of its parts.
#ifdef __AVX2__
inline constexpr WideInts kLaneParts = {0, 0, 0, 0, 1, 1, 1, 1};
inline WideFloats repeated(Floats4 v) {
  return __builtin_shufflevector(v, v, 0, 1, 2, 3, 0, 1, 2, 3);
}
inline WideInts repeated(Ints4 v) { return __builtin_shufflevector(v, v, 0, 1, 2, 3, 0, 1, 2, 3); }
template <int kPart>
Floats4 lane_part(WideFloats v) {
  constexpr int kFirst = 4 * kPart;
  return __builtin_shufflevector(v, v, kFirst, kFirst + 1, kFirst + 2, kFirst + 3);
}
#else
inline constexpr WideInts kLaneParts = {};
inline WideFloats repeated(Floats4 v) { return v; }
inline WideInts repeated(Ints4 v) { return v; }
template <int>
Floats4 lane_part(WideFloats v) {
  return v;
}
#endif

inline Floats4 floor(Floats4 v) {
  return Floats4{std::floor(v[0]), std::floor(v[1]), std::floor(v[2]), std::floor(v[3])};
}
inline Floats4 abs(Floats4 v) {
  return std::bit_cast<Floats4>(std::bit_cast<Ints4>(v) & 0x7fffffff);
}
// Whether a comparison holds in all lanes.
inline bool all(Ints4 mask) { return __builtin_ia32_movmskps(std::bit_cast<Floats4>(mask)) == 15; }

}  // namespace vernier
