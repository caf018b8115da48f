#include "textures/noise.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "math/lanes.h"
#include "textures/hash.h"

namespace vernier {
namespace {

// Four points, one to a lane.
template <int N>
using Points = std::array<Floats4, N>;

// The corners of a cell of the lattice that differ in the first dimension alone share a vector that
// is wide enough for both.
constexpr int kShared = kWideLanes / 4;

Floats4 fade(Floats4 t) { return t * t * t * (t * (t * 6.0f - 15.0f) + 10.0f); }

// Negative where the bit of the hash is set: for select().
WideInts negative_if(WideWords hash, int bit) {
  return std::bit_cast<WideInts>(hash << (31 - bit));
}
WideFloats select(WideInts negative, WideFloats a, WideFloats b) { return negative < 0 ? a : b; }
// The value with its sign turned where the bit is set.
WideFloats negate_if(WideFloats value, WideWords hash, int bit) {
  return std::bit_cast<WideFloats>(std::bit_cast<WideWords>(value) ^ hash >> bit << 31);
}

// Dot products of a lattice point's gradient with the offset from it.
WideFloats gradient(WideWords hash, WideFloats x) {
  const auto slope = std::bit_cast<WideInts>(1u + (hash & 7u));
  return negate_if(__builtin_convertvector(slope, WideFloats), hash, 3) * x;
}
WideFloats gradient(WideWords hash, WideFloats x, WideFloats y) {
  const WideInts h4 = negative_if(hash, 2);
  const WideFloats u = select(h4, y, x);
  const WideFloats v = 2.0f * select(h4, x, y);
  return negate_if(u, hash, 0) + negate_if(v, hash, 1);
}
WideFloats gradient(WideWords hash, WideFloats x, WideFloats y, WideFloats z) {
  const WideInts h8 = negative_if(hash, 3), h4 = negative_if(hash, 2), h1 = negative_if(hash, 0);
  const WideFloats u = select(h8, y, x);
  const WideFloats v = select(h8, select(h4 & ~h1, x, z), select(h4, z, y));
  return negate_if(u, hash, 0) + negate_if(v, hash, 1);
}
WideFloats gradient(WideWords hash, WideFloats x, WideFloats y, WideFloats z, WideFloats w) {
  const WideInts h16 = negative_if(hash, 4), h8 = negative_if(hash, 3);
  const WideFloats u = select(h16 & h8, y, x);
  const WideFloats v = select(h16, z, y);
  const WideFloats s = select(h16 | h8, w, z);
  return negate_if(u, hash, 0) + negate_if(v, hash, 1) + negate_if(s, hash, 2);
}

template <int N>
[[gnu::noinline]] Floats4 perlin(const Points<N>& p) {
  std::array<std::array<WideWords, 2>, N> cell;     // of the lower and the upper corners
  std::array<std::array<WideFloats, 2>, N> offset;  // from them
  Points<N> t;
  for (size_t d = 0; d < N; ++d) {
    const Floats4 below = floor(p[d]);
    const WideInts upper = d == 0 ? kLaneParts : WideInts{};
    const auto c =
        std::bit_cast<WideWords>(repeated(__builtin_convertvector(below, Ints4)) + upper);
    const WideFloats o = repeated(p[d] - below) - __builtin_convertvector(upper, WideFloats);
    cell[d] = {c, c + 1u};
    offset[d] = {o, o - 1.0f};
    t[d] = fade(p[d] - below);
  }
  std::array<Floats4, 1 << N> corner;  // the first dimension in the lowest bit
#pragma GCC unroll 16
  for (size_t i = 0; i < corner.size(); i += kShared) {
    const auto c = [&](size_t d) { return cell[d][i >> d & 1u]; };
    const auto o = [&](size_t d) { return offset[d][i >> d & 1u]; };
    WideFloats value;
    if constexpr (N == 1) {
      value = gradient(hash_words(c(0)), o(0));
    } else if constexpr (N == 2) {
      value = gradient(hash_words(c(0), c(1)), o(0), o(1));
    } else if constexpr (N == 3) {
      value = gradient(hash_words(c(0), c(1), c(2)), o(0), o(1), o(2));
    } else {
      value = gradient(hash_words(c(0), c(1), c(2), c(3)), o(0), o(1), o(2), o(3));
    }
    corner[i] = lane_part<0>(value);
    if constexpr (kShared == 2) {
      corner[i + 1] = lane_part<1>(value);
    }
  }
  for (size_t d = 0; d < N; ++d) {
#pragma GCC unroll 8
    for (size_t i = 0; i < corner.size() >> (d + 1); ++i) {
      corner[i] = corner[2 * i] + t[d] * (corner[2 * i + 1] - corner[2 * i]);
    }
  }
  return corner[0];
}

constexpr float kPeriod = 100000.0f;

[[gnu::noinline]] Floats4 wrapped(Floats4 v) {
  for (int lane = 0; lane < 4; ++lane) {
    const float x = v[lane];
    // From 1e6 on floats are so sparse that all would be lattice points, where noise is zero.
    const float correction = std::abs(x) >= 1000000.0f ? 0.5f : 0.0f;
    v[lane] = (std::isfinite(x) ? std::fmod(x, kPeriod) : 0.0f) + correction;
  }
  return v;
}

// Signed noise in about [-1, 1]. It repeats every kPeriod.
template <int N>
Floats4 signed_noise(Points<N> p) {
  // Scales to about [-1, 1] by dimension, from Open Shading Language.
  constexpr std::array<float, 4> kScale{0.2500f, 0.6616f, 0.9820f, 0.8344f};
  Ints4 near_origin = abs(p[0]) < kPeriod;
  for (size_t d = 1; d < N; ++d) {
    near_origin &= abs(p[d]) < kPeriod;
  }
  if (!all(near_origin)) {
    std::transform(p.begin(), p.end(), p.begin(), wrapped);
  }
  return kScale[N - 1] * perlin<N>(p);
}

// As many as detail's range asks for: a multiple of the lanes.
constexpr size_t kMaxOctaves = 16;
using Octaves = std::array<float, kMaxOctaves>;

// x and three times the product of what precedes with `ratio`.
Floats4 progression(float x, float ratio) {
  const float second = x * ratio, third = second * ratio;
  return Floats4{x, second, third, third * ratio};
}

// Signed noise at `p` and where the lacunarity takes it: at least `count` octaves.
template <int N>
Octaves octave_noise(std::array<float, N> p, const FractalParams& params, uint32_t count) {
  Octaves octaves;
  float first = 1.0f;
  for (uint32_t i = 0; i < count; i += 4) {
    const Floats4 scale = progression(first, params.lacunarity);
    first = scale[3] * params.lacunarity;
    Points<N> points;
    for (size_t d = 0; d < N; ++d) {
      // Rounded as in Cycles.
      if (params.kind == NoiseKind::kFbm) {
        points[d] = p[d] * scale;
      } else {
        points[d] = progression(p[d], params.lacunarity);
        p[d] = points[d][3] * params.lacunarity;
      }
    }
    const Floats4 noise = signed_noise<N>(points);
    std::memcpy(&octaves[i], &noise, sizeof noise);
  }
  return octaves;
}

float fbm(const Octaves& noise, const FractalParams& f) {
  float amplitude = 1.0f, largest = 0.0f, sum = 0.0f;
  const auto octaves = static_cast<uint32_t>(f.detail) + 1;
  for (uint32_t i = 0; i < octaves; ++i) {
    sum += noise[i] * amplitude;
    largest += amplitude;
    amplitude *= f.roughness;
  }
  const auto value = [&f](float s, float m) { return f.normalize ? 0.5f * s / m + 0.5f : s; };
  const float fraction = f.detail - std::floor(f.detail);
  if (fraction == 0.0f) {
    return value(sum, largest);
  }
  const float next = sum + noise[octaves] * amplitude;
  const float a = value(sum, largest);
  return a + fraction * (value(next, largest + amplitude) - a);
}

float multifractal(const Octaves& noise, const FractalParams& f) {
  float value = 1.0f, power = 1.0f;
  const auto octaves = static_cast<uint32_t>(f.detail) + 1;
  for (uint32_t i = 0; i < octaves; ++i) {
    value *= power * noise[i] + 1.0f;
    power *= f.roughness;
  }
  const float fraction = f.detail - std::floor(f.detail);
  return fraction == 0.0f ? value : value * (fraction * power * noise[octaves] + 1.0f);
}

float hetero_terrain(const Octaves& noise, const FractalParams& f) {
  float power = f.roughness;
  float value = f.offset + noise[0];
  const auto octaves = static_cast<uint32_t>(f.detail) + 1;
  for (uint32_t i = 1; i < octaves; ++i) {
    value += (noise[i] + f.offset) * power * value;
    power *= f.roughness;
  }
  const float fraction = f.detail - std::floor(f.detail);
  if (fraction != 0.0f) {
    value += fraction * (noise[octaves] + f.offset) * power * value;
  }
  return value;
}

float hybrid_multifractal(const Octaves& noise, const FractalParams& f) {
  constexpr float kNegligible = 0.001f;  // weight below which Cycles stops
  float power = 1.0f, value = 0.0f, weight = 1.0f;
  const auto octaves = static_cast<uint32_t>(f.detail) + 1;
  uint32_t i = 0;
  for (; weight > kNegligible && i < octaves; ++i) {
    weight = std::min(weight, 1.0f);
    const float signal = (noise[i] + f.offset) * power;
    power *= f.roughness;
    value += weight * signal;
    weight *= f.gain * signal;
  }
  const float fraction = f.detail - std::floor(f.detail);
  if (fraction != 0.0f && weight > kNegligible) {
    value += fraction * std::min(weight, 1.0f) * (noise[i] + f.offset) * power;
  }
  return value;
}

float ridged_multifractal(const Octaves& noise, const FractalParams& f) {
  float power = f.roughness;
  float signal = square(f.offset - std::abs(noise[0]));
  float value = signal;
  const auto octaves = static_cast<uint32_t>(f.detail) + 1;
  for (uint32_t i = 1; i < octaves; ++i) {
    const float weight = saturate(signal * f.gain);
    signal = square(f.offset - std::abs(noise[i])) * weight;
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
    Points<N> points;  // one for each axis
    for (size_t d = 0; d < N; ++d) {
      const auto seed = [d](size_t axis) { return axis < N ? kSeedOffsets<N>[axis][d] : 0.0f; };
      points[d] = p[d] + Floats4{seed(0), seed(1), seed(2), seed(3)};
    }
    const Floats4 noise = signed_noise<N>(points);
    for (size_t d = 0; d < N; ++d) {
      p[d] += noise[d] * distortion;
    }
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
float fractal_noise(const std::array<float, N>& p, const FractalParams& params) {
  const auto count = static_cast<uint32_t>(std::ceil(params.detail)) + 1;
  const Octaves noise = octave_noise<N>(p, params, count);
  switch (params.kind) {
    case NoiseKind::kFbm:
      return fbm(noise, params);
    case NoiseKind::kMultifractal:
      return multifractal(noise, params);
    case NoiseKind::kRidgedMultifractal:
      return ridged_multifractal(noise, params);
    case NoiseKind::kHybridMultifractal:
      return hybrid_multifractal(noise, params);
    case NoiseKind::kHeteroTerrain:
      return hetero_terrain(noise, params);
  }
  return 0.0f;
}

template float fractal_noise<3>(const std::array<float, 3>& p, const FractalParams& params);

void noise_texture(int dimensions, std::span<const Vec4f> points, const FractalParams& params,
                   float distortion, bool color, Vec3f* values) {
  const auto each = [&]<int N>(const auto& coordinates) {
    for (const Vec4f& p : points) {
      *values++ = evaluate<N>(coordinates(p), params, distortion, color);
    }
  };
  using std::array;
  switch (dimensions) {
    case 1:
      return each.operator()<1>([](const Vec4f& p) { return array{p.w}; });
    case 2:
      return each.operator()<2>([](const Vec4f& p) { return array{p.x, p.y}; });
    case 3:
      return each.operator()<3>([](const Vec4f& p) { return array{p.x, p.y, p.z}; });
    default:
      return each.operator()<4>([](const Vec4f& p) { return array{p.x, p.y, p.z, p.w}; });
  }
}

}  // namespace vernier
