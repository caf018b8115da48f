// Gradient noise and its fractal sums in 1 to 4 dimensions (Perlin 2002; Musgrave et al. 2003),
// with the lattice hash and the scales of Cycles (kernel/svm/noise.h, fractal_noise.h).
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "math/vec.h"

namespace vernier {

// The default comes first; the node's table has the same order.
enum class NoiseKind : uint8_t {
  kFbm,
  kMultifractal,
  kRidgedMultifractal,
  kHybridMultifractal,
  kHeteroTerrain,
};

struct FractalParams {
  NoiseKind kind = NoiseKind::kFbm;
  bool normalize = true;  // kFbm: to [0, 1]
  float detail = 2.0f;    // octaves beyond the first, [0, 15]; a fraction blends one in
  float roughness = 0.5f;
  float lacunarity = 2.0f;
  float offset = 0.0f;
  float gain = 1.0f;
};

template <int N>
float fractal_noise(const std::array<float, N>& p, const FractalParams& params);

// The Noise Texture node at several points: x of a value is its Fac and red; with `color` y and z
// are the other channels. The points are scaled already; one dimension reads w, two read x and y.
void noise_texture(int dimensions, std::span<const Vec4f> points, const FractalParams& params,
                   float distortion, bool color, Vec3f* values);

}  // namespace vernier
