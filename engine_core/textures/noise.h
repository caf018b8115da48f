// Gradient noise and its fractal sums in 1 to 4 dimensions (Perlin 2002; Musgrave et al. 2003),
// with the lattice hash and the scales of Cycles (kernel/svm/noise.h, fractal_noise.h).
#pragma once

#include <array>
#include <cstdint>

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

// The Noise Texture node: x is its Fac and red; with `color` y and z are the other channels.
// `p` is scaled already; one dimension reads w, two read x and y.
Vec3f noise_texture(int dimensions, const Vec4f& p, const FractalParams& params, float distortion,
                    bool color);

}  // namespace vernier
