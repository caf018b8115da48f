// Small fixed-size vectors in float32: points, directions, colours.
//
// Three plain floats, no SIMD padding: compilers vectorise what pays, and arrays stay dense.
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <limits>

namespace vernier {

inline constexpr float kInfinity = std::numeric_limits<float>::infinity();
inline constexpr float kPi = 3.14159265358979323846f;
inline constexpr float kTwoPi = 6.28318530717958647693f;
inline constexpr float kInvPi = 0.31830988618379067154f;
inline constexpr float kInvTwoPi = 0.15915494309189533577f;
inline constexpr float kInvFourPi = 0.07957747154594766788f;
// The largest float32 below 1: the upper end of every canonical random number.
inline constexpr float kOneMinusEpsilon = 0x1.fffffep-1f;
// Unit round-off u of float32 (half of FLT_EPSILON).
inline constexpr float kUnitRoundoff = 0x1p-24f;

// Bound gamma_n of the relative error of n float32 operations (Higham 2002, section 3.1).
constexpr float gamma(int n) {
  return (static_cast<float>(n) * kUnitRoundoff) / (1.0f - static_cast<float>(n) * kUnitRoundoff);
}

struct Vec2f {
  float x = 0, y = 0;
};

constexpr Vec2f operator+(Vec2f a, Vec2f b) { return {a.x + b.x, a.y + b.y}; }
constexpr Vec2f operator-(Vec2f a, Vec2f b) { return {a.x - b.x, a.y - b.y}; }
constexpr Vec2f operator*(Vec2f a, float s) { return {a.x * s, a.y * s}; }
constexpr Vec2f operator*(float s, Vec2f a) { return a * s; }

struct Vec3f {
  float x = 0, y = 0, z = 0;

  constexpr float operator[](int i) const { return i == 0 ? x : (i == 1 ? y : z); }
  constexpr float& operator[](int i) { return i == 0 ? x : (i == 1 ? y : z); }

  constexpr Vec3f& operator+=(Vec3f b) {
    x += b.x, y += b.y, z += b.z;
    return *this;
  }
  constexpr Vec3f& operator-=(Vec3f b) {
    x -= b.x, y -= b.y, z -= b.z;
    return *this;
  }
  constexpr Vec3f& operator*=(Vec3f b) {
    x *= b.x, y *= b.y, z *= b.z;
    return *this;
  }
  constexpr Vec3f& operator*=(float s) {
    x *= s, y *= s, z *= s;
    return *this;
  }
};

// Linear RGB in the scene's working space (Rec.709 primaries in Blender's default configuration).
using Color = Vec3f;

constexpr Vec3f operator+(Vec3f a, Vec3f b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
constexpr Vec3f operator-(Vec3f a, Vec3f b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
constexpr Vec3f operator-(Vec3f a) { return {-a.x, -a.y, -a.z}; }
constexpr Vec3f operator*(Vec3f a, Vec3f b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
constexpr Vec3f operator*(Vec3f a, float s) { return {a.x * s, a.y * s, a.z * s}; }
constexpr Vec3f operator*(float s, Vec3f a) { return a * s; }
constexpr Vec3f operator/(Vec3f a, float s) { return a * (1.0f / s); }
constexpr Vec3f operator/(Vec3f a, Vec3f b) { return {a.x / b.x, a.y / b.y, a.z / b.z}; }
constexpr bool operator==(Vec3f a, Vec3f b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

constexpr Vec3f splat(float s) { return {s, s, s}; }
constexpr float dot(Vec3f a, Vec3f b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
constexpr float length_squared(Vec3f a) { return dot(a, a); }
inline float length(Vec3f a) { return std::sqrt(dot(a, a)); }
constexpr Vec3f cross(Vec3f a, Vec3f b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Vec3f abs(Vec3f a) { return {std::abs(a.x), std::abs(a.y), std::abs(a.z)}; }
constexpr float max_component(Vec3f a) { return std::max(a.x, std::max(a.y, a.z)); }
constexpr float min_component(Vec3f a) { return std::min(a.x, std::min(a.y, a.z)); }
constexpr float average(Vec3f a) { return (a.x + a.y + a.z) * (1.0f / 3.0f); }
constexpr Vec3f min(Vec3f a, Vec3f b) {
  return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
constexpr Vec3f max(Vec3f a, Vec3f b) {
  return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}
constexpr Vec3f lerp(Vec3f a, Vec3f b, float t) { return a * (1.0f - t) + b * t; }
constexpr float lerp(float a, float b, float t) { return a * (1.0f - t) + b * t; }
constexpr float clamp(float v, float lo, float hi) { return std::min(std::max(v, lo), hi); }
constexpr float saturate(float v) { return clamp(v, 0.0f, 1.0f); }
template <std::floating_point T>
constexpr T square(T v) {
  return v * v;
}
// sqrt of a quantity that is non-negative but for rounding.
inline float safe_sqrt(float v) { return std::sqrt(std::max(v, 0.0f)); }

// Unit vector along `a`; scaled by its largest component first, so that no length between the
// smallest normal float and the largest overflows or flushes to zero. The zero vector stays zero.
inline Vec3f normalize(Vec3f a) {
  const float squared = dot(a, a);
  if (squared > 1e-30f && squared < 1e30f) {
    return a * (1.0f / std::sqrt(squared));
  }
  const float scale = max_component(abs(a));
  if (!(scale > 0.0f) || !(scale < kInfinity)) {
    return {};
  }
  const Vec3f b = a / splat(scale);
  return b * (1.0f / std::sqrt(dot(b, b)));
}

inline bool is_finite(Vec3f a) {
  return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}
constexpr bool is_black(Color c) { return c.x == 0.0f && c.y == 0.0f && c.z == 0.0f; }

// Relative luminance of linear Rec.709 RGB (ITU-R BT.709-6, item 3.2).
constexpr float luminance(Color c) { return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z; }

struct Vec4f {
  float x = 0, y = 0, z = 0, w = 0;

  constexpr Vec3f xyz() const { return {x, y, z}; }
};

constexpr Vec4f operator+(Vec4f a, Vec4f b) { return {a.x + b.x, a.y + b.y, a.z + b.z, a.w + b.w}; }
constexpr Vec4f operator*(Vec4f a, float s) { return {a.x * s, a.y * s, a.z * s, a.w * s}; }

}  // namespace vernier
