#include "textures/noise.h"

#include <bit>

#include "textures/hash.h"

namespace vernier {
namespace {

float fade(float t) { return t * t * t * (t * (t * 6.0f - 15.0f) + 10.0f); }

// The value with its sign turned where bit `bit` of the hash is set; no branch, so that the corners
// of a cell are computed side by side by vector instructions.
float negate_if(float value, uint32_t hash, int bit) {
  return std::bit_cast<float>(std::bit_cast<uint32_t>(value) ^ (hash >> bit << 31));
}

// Dot products of a lattice point's gradient with the offset from it.
float gradient(uint32_t hash, float x) {
  return negate_if(static_cast<float>(1 + (hash & 7u)), hash, 3) * x;
}
float gradient(uint32_t hash, float x, float y) {
  const uint32_t h = hash & 7u;
  const float u = h < 4 ? x : y;
  const float v = 2.0f * (h < 4 ? y : x);
  return negate_if(u, h, 0) + negate_if(v, h, 1);
}
float gradient(uint32_t hash, float x, float y, float z) {
  const uint32_t h = hash & 15u;
  const float u = h < 8 ? x : y;
  const float v = h < 4 ? y : (h == 12 || h == 14 ? x : z);
  return negate_if(u, h, 0) + negate_if(v, h, 1);
}
float gradient(uint32_t hash, float x, float y, float z, float w) {
  const uint32_t h = hash & 31u;
  const float u = h < 24 ? x : y;
  const float v = h < 16 ? y : z;
  const float s = h < 8 ? z : w;
  return negate_if(u, h, 0) + negate_if(v, h, 1) + negate_if(s, h, 2);
}

// Interpolates 2^N corner values, the first dimension in the lowest bit.
template <int N>
float interpolate(std::array<float, 1 << N>& corner, const std::array<float, N>& t) {
  for (int d = 0; d < N; ++d) {
    const int half = (1 << N) >> (d + 1);
    for (int i = 0; i < half; ++i) {
      const auto even = static_cast<size_t>(2 * i);
      corner[static_cast<size_t>(i)] =
          corner[even] + t[static_cast<size_t>(d)] * (corner[even + 1] - corner[even]);
    }
  }
  return corner[0];
}

template <int N>
float perlin(const std::array<float, N>& p) {
  std::array<uint32_t, N> cell;
  std::array<float, N> offset, t;
  for (size_t d = 0; d < N; ++d) {
    const float floor = std::floor(p[d]);
    cell[d] = static_cast<uint32_t>(static_cast<int32_t>(floor));
    offset[d] = p[d] - floor;
    t[d] = fade(offset[d]);
  }
  std::array<float, 1 << N> corner;
  for (uint32_t i = 0; i < 1u << N; ++i) {
    const auto c = [&](uint32_t d) { return cell[d] + (i >> d & 1u); };
    const auto o = [&](uint32_t d) { return offset[d] - static_cast<float>(i >> d & 1u); };
    if constexpr (N == 1) {
      corner[i] = gradient(hash_words(c(0)), o(0));
    } else if constexpr (N == 2) {
      corner[i] = gradient(hash_words(c(0), c(1)), o(0), o(1));
    } else if constexpr (N == 3) {
      corner[i] = gradient(hash_words(c(0), c(1), c(2)), o(0), o(1), o(2));
    } else {
      corner[i] = gradient(hash_words(c(0), c(1), c(2), c(3)), o(0), o(1), o(2), o(3));
    }
  }
  return interpolate<N>(corner, t);
}

template <int N>
std::array<float, N> scaled(std::array<float, N> p, float s) {
  for (float& x : p) {
    x *= s;
  }
  return p;
}

template <int N>
float fbm(const std::array<float, N>& p, const FractalParams& f) {
  float scale = 1.0f, amplitude = 1.0f, largest = 0.0f, sum = 0.0f;
  const auto octaves = static_cast<int>(f.detail);
  for (int i = 0; i <= octaves; ++i) {
    sum += signed_noise<N>(scaled<N>(p, scale)) * amplitude;
    largest += amplitude;
    amplitude *= f.roughness;
    scale *= f.lacunarity;
  }
  const auto value = [&f](float s, float m) { return f.normalize ? 0.5f * s / m + 0.5f : s; };
  const float fraction = f.detail - std::floor(f.detail);
  if (fraction == 0.0f) {
    return value(sum, largest);
  }
  const float next = sum + signed_noise<N>(scaled<N>(p, scale)) * amplitude;
  const float a = value(sum, largest);
  return a + fraction * (value(next, largest + amplitude) - a);
}

template <int N>
float multifractal(std::array<float, N> p, const FractalParams& f) {
  float value = 1.0f, power = 1.0f;
  for (int i = 0; i <= static_cast<int>(f.detail); ++i) {
    value *= power * signed_noise<N>(p) + 1.0f;
    power *= f.roughness;
    p = scaled<N>(p, f.lacunarity);
  }
  const float fraction = f.detail - std::floor(f.detail);
  return fraction == 0.0f ? value : value * (fraction * power * signed_noise<N>(p) + 1.0f);
}

template <int N>
float hetero_terrain(std::array<float, N> p, const FractalParams& f) {
  float power = f.roughness;
  float value = f.offset + signed_noise<N>(p);
  p = scaled<N>(p, f.lacunarity);
  for (int i = 1; i <= static_cast<int>(f.detail); ++i) {
    value += (signed_noise<N>(p) + f.offset) * power * value;
    power *= f.roughness;
    p = scaled<N>(p, f.lacunarity);
  }
  const float fraction = f.detail - std::floor(f.detail);
  if (fraction != 0.0f) {
    value += fraction * (signed_noise<N>(p) + f.offset) * power * value;
  }
  return value;
}

template <int N>
float hybrid_multifractal(std::array<float, N> p, const FractalParams& f) {
  constexpr float kNegligible = 0.001f;  // weight below which Cycles stops
  float power = 1.0f, value = 0.0f, weight = 1.0f;
  for (int i = 0; weight > kNegligible && i <= static_cast<int>(f.detail); ++i) {
    weight = std::min(weight, 1.0f);
    const float signal = (signed_noise<N>(p) + f.offset) * power;
    power *= f.roughness;
    value += weight * signal;
    weight *= f.gain * signal;
    p = scaled<N>(p, f.lacunarity);
  }
  const float fraction = f.detail - std::floor(f.detail);
  if (fraction != 0.0f && weight > kNegligible) {
    value += fraction * std::min(weight, 1.0f) * (signed_noise<N>(p) + f.offset) * power;
  }
  return value;
}

template <int N>
float ridged_multifractal(std::array<float, N> p, const FractalParams& f) {
  float power = f.roughness;
  float signal = square(f.offset - std::abs(signed_noise<N>(p)));
  float value = signal;
  for (int i = 1; i <= static_cast<int>(f.detail); ++i) {
    p = scaled<N>(p, f.lacunarity);
    const float weight = saturate(signal * f.gain);
    signal = square(f.offset - std::abs(signed_noise<N>(p))) * weight;
    value += signal * power;
    power *= f.roughness;
  }
  return value;
}

// Offsets in [100, 200] that stand for the seeds 0 to N + 1.
template <int N>
constexpr auto kSeedOffsets = [] {
  std::array<std::array<float, N>, N + 2> offsets{};
  for (size_t seed = 0; seed < offsets.size(); ++seed) {
    const auto s = static_cast<float>(seed);
    for (size_t d = 0; d < N; ++d) {
      const float hash = N == 1 ? hash_floats(s) : hash_floats(s, static_cast<float>(d));
      offsets[seed][d] = 100.0f + hash * 100.0f;
    }
  }
  return offsets;
}();

template <int N>
std::array<float, N> seeded(std::array<float, N> p, size_t seed) {
  for (size_t d = 0; d < N; ++d) {
    p[d] += kSeedOffsets<N>[seed][d];
  }
  return p;
}

template <int N>
Vec3f evaluate(std::array<float, N> p, const FractalParams& params, float distortion, bool color) {
  if (distortion != 0.0f) {
    std::array<float, N> moved = p;
    for (size_t d = 0; d < N; ++d) {
      moved[d] += signed_noise<N>(seeded<N>(p, d)) * distortion;
    }
    p = moved;
  }
  Vec3f value{fractal_noise<N>(p, params), 0.0f, 0.0f};
  if (color) {
    value.y = fractal_noise<N>(seeded<N>(p, N), params);
    value.z = fractal_noise<N>(seeded<N>(p, N + 1), params);
  }
  return value;
}

}  // namespace

template <int N>
float signed_noise(const std::array<float, N>& p) {
  constexpr float kPeriod = 100000.0f;
  // Scales to about [-1, 1] by dimension, from Open Shading Language.
  constexpr std::array<float, 4> kScale{0.2500f, 0.6616f, 0.9820f, 0.8344f};
  const auto near_origin = [](float x) { return std::abs(x) < kPeriod; };
  if (std::all_of(p.begin(), p.end(), near_origin)) {
    return kScale[N - 1] * perlin<N>(p);
  }
  std::array<float, N> q;
  for (size_t d = 0; d < N; ++d) {
    // From 1e6 on floats are so sparse that all would be lattice points, where noise is zero.
    const float correction = std::abs(p[d]) >= 1000000.0f ? 0.5f : 0.0f;
    q[d] = (std::isfinite(p[d]) ? std::fmod(p[d], kPeriod) : 0.0f) + correction;
  }
  return kScale[N - 1] * perlin<N>(q);
}

template <int N>
float fractal_noise(std::array<float, N> p, const FractalParams& params) {
  switch (params.kind) {
    case NoiseKind::kFbm:
      return fbm<N>(p, params);
    case NoiseKind::kMultifractal:
      return multifractal<N>(p, params);
    case NoiseKind::kRidgedMultifractal:
      return ridged_multifractal<N>(p, params);
    case NoiseKind::kHybridMultifractal:
      return hybrid_multifractal<N>(p, params);
    case NoiseKind::kHeteroTerrain:
      return hetero_terrain<N>(p, params);
  }
  return 0.0f;
}

template float fractal_noise<3>(std::array<float, 3> p, const FractalParams& params);

Vec3f noise_texture(int dimensions, Vec4f p, const FractalParams& params, float distortion,
                    bool color) {
  switch (dimensions) {
    case 1:
      return evaluate<1>({p.w}, params, distortion, color);
    case 2:
      return evaluate<2>({p.x, p.y}, params, distortion, color);
    case 3:
      return evaluate<3>({p.x, p.y, p.z}, params, distortion, color);
    default:
      return evaluate<4>({p.x, p.y, p.z, p.w}, params, distortion, color);
  }
}

}  // namespace vernier
