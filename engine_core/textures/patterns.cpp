#include "textures/patterns.h"

#include "textures/hash.h"
#include "textures/noise.h"

namespace vernier {
namespace {

// Off the integers, where rounding would flip neighbours; Cycles' own amounts.
Vec3f off_lattice(Vec3f p) { return (p + splat(0.000001f)) * 0.999999f; }

// floor() to an integer, at the ends of its range where that is exceeded; NaN gives 0.
int floor_to_int(float x) {
  return x == x ? static_cast<int>(clamp(std::floor(x), -2147483520.0f, 2147483520.0f)) : 0;
}

// Hash of a brick's number to [0, 1] (the integer noise of Elias 1998).
float brick_noise(uint32_t n) {
  n = (n + 1013u) & 0x7fffffffu;
  n = (n >> 13) ^ n;
  const uint32_t mixed = (n * (n * n * 60493u + 19990303u) + 1376312589u) & 0x7fffffffu;
  return 0.5f * (static_cast<float>(mixed) / 1073741824.0f);
}

}  // namespace

float checker(Vec3f p) {
  const Vec3f q = off_lattice(p);
  const auto odd = [](float x) { return std::fmod(std::abs(std::floor(x)), 2.0f) != 0.0f; };
  return (odd(q.x) == odd(q.y)) == odd(q.z) ? 1.0f : 0.0f;
}

float gradient_texture(GradientKind kind, Vec3f p) {
  // A little below 1 - |p|, so that unit vectors give exactly zero, as in Cycles.
  const auto sphere = [&] { return std::max(0.999999f - length(p), 0.0f); };
  switch (kind) {
    case GradientKind::kLinear:
      return saturate(p.x);
    case GradientKind::kQuadratic:
      return square(saturate(p.x));
    case GradientKind::kEasing: {
      const float r = saturate(p.x);
      return r * r * (3.0f - 2.0f * r);
    }
    case GradientKind::kDiagonal:
      return saturate((p.x + p.y) * 0.5f);
    case GradientKind::kSpherical:
      return sphere();
    case GradientKind::kQuadraticSphere:
      return square(sphere());
    case GradientKind::kRadial:
      return saturate(std::atan2(p.y, p.x) * kInvTwoPi + 0.5f);
  }
  return 0.0f;
}

Vec2f bricks(Vec3f p, const Bricks& b) {
  const int row = floor_to_int(p.y / b.row_height);
  float width = b.brick_width;
  float shift = 0.0f;
  if (b.offset_frequency != 0 && b.squash_frequency != 0) {
    width *= row % b.squash_frequency != 0 ? 1.0f : b.squash;
    shift = row % b.offset_frequency != 0 ? 0.0f : width * b.offset;
  }
  const int brick = floor_to_int((p.x + shift) / width);
  const float x = (p.x + shift) - width * static_cast<float>(brick);
  const float y = p.y - b.row_height * static_cast<float>(row);

  const uint32_t number =
      (static_cast<uint32_t>(row) << 16) + (static_cast<uint32_t>(brick) & 0xffffu);
  const float tint = saturate(brick_noise(number) + b.bias);
  const float edge = std::min(std::min(x, y), std::min(width - x, b.row_height - y));
  if (edge >= b.mortar_size) {
    return {tint, 0.0f};
  }
  if (b.mortar_smooth == 0.0f) {
    return {tint, 1.0f};
  }
  const float t = saturate((1.0f - edge / b.mortar_size) / b.mortar_smooth);
  return {tint, t * t * (3.0f - 2.0f * t)};
}

float wave(Vec3f p, const Wave& w) {
  p = off_lattice(p);
  float n;
  if (w.kind == WaveKind::kBands) {
    switch (w.direction) {
      case WaveDirection::kX:
        n = p.x * 20.0f;
        break;
      case WaveDirection::kY:
        n = p.y * 20.0f;
        break;
      case WaveDirection::kZ:
        n = p.z * 20.0f;
        break;
      default:
        n = (p.x + p.y + p.z) * 10.0f;
    }
  } else {
    Vec3f r = p;
    if (w.direction != WaveDirection::kAll) {
      r[static_cast<int>(w.direction)] = 0.0f;
    }
    n = length(r) * 20.0f;
  }
  n += w.phase;
  if (w.distortion != 0.0f) {
    FractalParams fractal;
    fractal.detail = w.detail;
    fractal.roughness = w.detail_roughness;
    const Vec3f q = p * w.detail_scale;
    n += w.distortion * (fractal_noise<3>({q.x, q.y, q.z}, fractal) * 2.0f - 1.0f);
  }
  if (w.profile == WaveProfile::kSine) {
    return 0.5f + 0.5f * std::sin(n - 0.5f * kPi);
  }
  n *= kInvTwoPi;
  return w.profile == WaveProfile::kSaw ? n - std::floor(n)
                                        : std::abs(n - std::floor(n + 0.5f)) * 2.0f;
}

// Up to ten rounds, each of which folds one coordinate over the others.
Color magic(Vec3f p, float scale, int depth, float distortion) {
  const auto wrapped = [&](float v) {
    const float x = v * scale;
    return std::isfinite(x) ? std::fmod(x, kTwoPi) : 0.0f;
  };
  const float px = wrapped(p.x), py = wrapped(p.y), pz = wrapped(p.z);
  float x = std::sin((px + py + pz) * 5.0f);
  float y = std::cos((-px + py - pz) * 5.0f);
  float z = -std::cos((-px - py + pz) * 5.0f);
  if (depth > 0) {
    x *= distortion;
    y *= distortion;
    z *= distortion;
  }
  for (int round = 0; round < std::min(depth, 10); ++round) {
    switch (round) {
      case 0:
        y = -std::cos(x - y + z) * distortion;
        break;
      case 1:
        x = std::cos(x - y - z) * distortion;
        break;
      case 2:
        z = std::sin(-x - y - z) * distortion;
        break;
      case 3:
        x = -std::cos(-x + y - z) * distortion;
        break;
      case 4:
        y = -std::sin(-x + y + z) * distortion;
        break;
      case 5:
        y = -std::cos(-x + y + z) * distortion;
        break;
      case 6:
        x = std::cos(x + y + z) * distortion;
        break;
      case 7:
        z = std::sin(x + y - z) * distortion;
        break;
      case 8:
        x = -std::cos(-x - y + z) * distortion;
        break;
      default:
        y = -std::sin(x - y + z) * distortion;
    }
  }
  if (distortion != 0.0f) {
    const float inverse = 0.5f / distortion;
    x *= inverse;
    y *= inverse;
    z *= inverse;
  }
  return {0.5f - x, 0.5f - y, 0.5f - z};
}

Vec3f white_noise(int dimensions, Vec4f p, bool color) {
  const float x = p.x, y = p.y, z = p.z, w = p.w;
  switch (dimensions) {
    case 1:
      return color ? Vec3f{hash_floats(w), hash_floats(w, 1.0f), hash_floats(w, 2.0f)}
                   : splat(hash_floats(w));
    case 2:
      return color ? Vec3f{hash_floats(x, y), hash_floats(x, y, 1.0f), hash_floats(x, y, 2.0f)}
                   : splat(hash_floats(x, y));
    case 3:
      return color ? Vec3f{hash_floats(x, y, z), hash_floats(x, y, z, 1.0f),
                           hash_floats(x, y, z, 2.0f)}
                   : splat(hash_floats(x, y, z));
    default:
      return color
                 ? Vec3f{hash_floats(x, y, z, w), hash_floats(z, x, w, y), hash_floats(w, z, y, x)}
                 : splat(hash_floats(x, y, z, w));
  }
}

}  // namespace vernier
