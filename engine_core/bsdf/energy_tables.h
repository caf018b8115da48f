// Directional albedos of GGX lobes: what single scattering between facets loses, and how far
// Fresnel has gone to white.
//
// Reflection and refraction at GGX facets lose light that would scatter more than once. As in
// Kulla and Conty (2017) and Turquin, "Practical multiple scattering compensation for microfacet
// models" (2019), the lobe is scaled up by what its own albedo table says is missing. The axes and
// the (bi- and trilinear) interpolation are those of Cycles; the entries are computed here, at
// load, by quadrature over visible normals.
#pragma once

#include <array>

#include "math/vec.h"

namespace vernier {

struct EnergyTables {
  static constexpr int kFine = 32, kCoarse = 16;
  static constexpr int kPlane = kCoarse * kCoarse, kVolume = kPlane * kCoarse;

  // Axes: roughness fastest, then the cosine, then ior_axis().
  std::array<float, kFine * kFine> reflection;
  std::array<float, kFine> reflection_average;  // over the cosine-weighted hemisphere
  std::array<float, kVolume> glass[2];          // index above 1; and its inverse
  std::array<float, kPlane> glass_average[2];   // axes: roughness, ior_axis()
  std::array<float, kVolume> dielectric_blend;  // mean of (F - F0) / (1 - F0)
  std::array<float, kPlane> schlick_blend;      // mean of Schlick's (1-cos)^5; no third axis

  EnergyTables();
};

// Filled when the library is loaded.
extern const EnergyTables energy_tables;

// Index of refraction (or its inverse) on a table's third axis, [0, 1).
inline float ior_axis(float ior) { return std::sqrt(std::abs((ior - 1.0f) / (ior + 1.0f))); }

namespace detail {
template <int kSize>
struct Axis {
  int i0, i1;
  float t;
  explicit Axis(float x) {
    const float s = saturate(x) * (kSize - 1);
    i0 = static_cast<int>(s);
    i1 = std::min(i0 + 1, kSize - 1);
    t = s - static_cast<float>(i0);
  }
};
}  // namespace detail

template <int kSize>
inline float lookup_1d(const float* table, float x) {
  const detail::Axis<kSize> a(x);
  return lerp(table[a.i0], table[a.i1], a.t);
}

template <int kSize>
inline float lookup_2d(const float* table, float x, float y) {
  const detail::Axis<kSize> a(x), b(y);
  const float* r0 = table + b.i0 * kSize;
  const float* r1 = table + b.i1 * kSize;
  return lerp(lerp(r0[a.i0], r0[a.i1], a.t), lerp(r1[a.i0], r1[a.i1], a.t), b.t);
}

template <int kSize>
inline float lookup_3d(const float* table, float x, float y, float z) {
  const detail::Axis<kSize> c(z);
  return lerp(lookup_2d<kSize>(table + c.i0 * kSize * kSize, x, y),
              lookup_2d<kSize>(table + c.i1 * kSize * kSize, x, y), c.t);
}

}  // namespace vernier
