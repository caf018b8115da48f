// Simple procedural patterns (Cycles: kernel/svm/checker.h, gradient.h, brick.h, wave.h, magic.h,
// white_noise.h). Coordinates are scaled already.
#pragma once

#include <cstdint>

#include "math/vec.h"

namespace vernier {

// 1 where the first colour shows, else 0.
float checker(Vec3f p);

// In the order of the nodes' enum items.
enum class GradientKind : uint8_t {
  kLinear,
  kQuadratic,
  kEasing,
  kDiagonal,
  kSpherical,
  kQuadraticSphere,
  kRadial,
};
float gradient_texture(GradientKind kind, Vec3f p);  // [0, 1]

struct Bricks {
  float mortar_size, mortar_smooth, bias, brick_width, row_height;
  float offset, squash;
  int offset_frequency, squash_frequency;
};
// x: tint of the brick, [0, 1]; y: share of mortar, [0, 1].
Vec2f bricks(Vec3f p, const Bricks& params);

enum class WaveKind : uint8_t { kBands, kRings };
enum class WaveDirection : uint8_t { kX, kY, kZ, kAll };  // kAll: diagonal bands, spherical rings
enum class WaveProfile : uint8_t { kSine, kSaw, kTriangle };
struct Wave {
  WaveKind kind;
  WaveDirection direction;
  WaveProfile profile;
  float distortion, detail, detail_scale, detail_roughness, phase;
};
float wave(Vec3f p, const Wave& params);  // [0, 1]

Color magic(Vec3f p, float scale, int depth, float distortion);

// Fac in x where `color` is false; p as for noise_texture().
Vec3f white_noise(int dimensions, Vec4f p, bool color);

}  // namespace vernier
