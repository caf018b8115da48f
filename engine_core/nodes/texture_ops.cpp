#include "nodes/texture_ops.h"

#include <algorithm>
#include <array>

#include "textures/noise.h"
#include "textures/patterns.h"
#include "textures/voronoi.h"

namespace vernier {
namespace {

// The vector and W inputs (operands 0 and 1) scaled by operand 2.
Vec4f scaled_coordinate(const Arguments& a) {
  const float scale = a.scalar(2);
  const Vec3f p = a.vector(0) * scale;
  return {p.x, p.y, p.z, a.scalar(1) * scale};
}

// Octaves beyond the first; none where the input is not a number.
float octaves(float detail) { return std::min(std::max(0.0f, detail), 15.0f); }

}  // namespace

void execute_noise(uint8_t variant, std::span<const Arguments> points, Vec4f* results) {
  const Arguments& a = points.front();
  FractalParams params;
  params.kind = static_cast<NoiseKind>(variant >> 2 & 7u);
  params.normalize = (variant & 32u) != 0;
  params.detail = octaves(a.scalar(3));
  params.roughness = std::max(a.scalar(4), 0.0f);
  params.lacunarity = a.scalar(5);
  params.offset = a.scalar(6);
  params.gain = a.scalar(7);
  const float distortion = a.scalar(8);
  const bool color = (variant & 64u) != 0;
  std::array<Vec4f, kEvaluationPoints> p;
  std::array<Vec3f, kEvaluationPoints> values;
  std::transform(points.begin(), points.end(), p.begin(), scaled_coordinate);
  noise_texture((variant & 3) + 1, {p.data(), points.size()}, params, distortion, color,
                values.data());
  for (size_t i = 0; i < points.size(); ++i) {
    results[i] = color ? to_register(values[i]) : to_register(values[i].x);
  }
}

// Operands: vector, colours 1 and 2, scale. w keeps Fac.
Vec4f execute_checker(const Arguments& a) {
  const float first = checker(a.vector(0) * a.scalar(3));
  const Vec3f color = first == 1.0f ? a.vector(1) : a.vector(2);
  return {color.x, color.y, color.z, first};
}

Vec4f execute_gradient(uint8_t variant, const Arguments& a) {
  return to_register(gradient_texture(static_cast<GradientKind>(variant), a.vector(0)));
}

// Operands: vector, colour 1, colour 2, mortar, scale, mortar size, smooth, bias, width, height.
// w keeps Fac.
Vec4f execute_brick(uint8_t, const Arguments& a, const float* data) {
  Bricks params;
  params.mortar_size = a.scalar(5);
  params.mortar_smooth = a.scalar(6);
  params.bias = a.scalar(7);
  params.brick_width = a.scalar(8);
  params.row_height = a.scalar(9);
  params.offset = data[0];
  params.squash = data[1];
  params.offset_frequency = static_cast<int>(data[2]);
  params.squash_frequency = static_cast<int>(data[3]);
  const Vec2f f = bricks(a.vector(0) * a.scalar(4), params);
  const Color brick = f.y != 1.0f ? lerp(a.vector(1), a.vector(2), f.x) : a.vector(1);
  const Color color = lerp(brick, a.vector(3), f.y);
  return {color.x, color.y, color.z, f.y};
}

// Operands: vector, scale, distortion, detail, detail scale, detail roughness, phase.
// Variant: kind, direction << 1, profile << 3.
Vec4f execute_wave(uint8_t variant, const Arguments& a) {
  Wave params;
  params.kind = static_cast<WaveKind>(variant & 1u);
  params.direction = static_cast<WaveDirection>(variant >> 1 & 3u);
  params.profile = static_cast<WaveProfile>(variant >> 3 & 3u);
  params.distortion = a.scalar(2);
  params.detail = octaves(a.scalar(3));
  params.detail_scale = a.scalar(4);
  params.detail_roughness = a.scalar(5);
  params.phase = a.scalar(6);
  return to_register(wave(a.vector(0) * a.scalar(1), params));
}

Vec4f execute_magic(uint8_t variant, const Arguments& a) {
  return to_register(magic(a.vector(0), a.scalar(1), variant, a.scalar(2)));
}

// Operands: vector, W, scale, detail, roughness, lacunarity, smoothness, exponent, randomness.
Vec4f execute_voronoi(uint8_t variant, const Arguments& a, const float* data) {
  VoronoiParams params;
  params.feature = static_cast<VoronoiFeature>(static_cast<int>(data[1]));
  params.metric = static_cast<VoronoiMetric>(static_cast<int>(data[2]));
  params.normalize = data[3] != 0.0f;
  params.scale = a.scalar(2);
  params.detail = clamp(a.scalar(3), 0.0f, 15.0f);
  params.roughness = saturate(a.scalar(4));
  params.lacunarity = a.scalar(5);
  params.smoothness = clamp(a.scalar(6) * 0.5f, 0.0f, 0.5f);
  params.exponent = a.scalar(7);
  params.randomness = saturate(a.scalar(8));
  const VoronoiCell cell = voronoi_texture(static_cast<int>(data[0]), scaled_coordinate(a), params);
  if (static_cast<VoronoiOutput>(variant) == VoronoiOutput::kPosition) {
    return cell.position;
  }
  return {cell.color.x, cell.color.y, cell.color.z, cell.distance};
}

Vec4f execute_white_noise(uint8_t variant, const Arguments& a) {
  const Vec3f p = a.vector(0);
  return to_register(
      white_noise((variant & 3) + 1, {p.x, p.y, p.z, a.scalar(1)}, (variant & 4u) != 0));
}

}  // namespace vernier
