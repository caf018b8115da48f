// Instructions of the procedural textures: operands to the functions of textures/.
#pragma once

#include <cstdint>
#include <span>

#include "nodes/program.h"

namespace vernier {

// A table in ProgramData::floats: rows, range of the argument, extrapolation, then rows of 4.
struct TableHeader {
  static constexpr int kSize = 4;

  explicit TableHeader(const float* table)
      : rows(table + kSize, 4 * static_cast<size_t>(table[0])),
        min(table[1]),
        max(table[2]),
        extrapolate(table[3] != 0.0f) {}

  std::span<const float> rows;
  float min, max;
  bool extrapolate;
};

// Variants. Noise: dimensions - 1, kind << 2, normalize << 5, colour << 6.
// White noise: dimensions - 1, colour << 2.

// One noise at several points (at most kEvaluationPoints), whose arguments differ in vector and W
// alone.
void execute_noise(uint8_t variant, std::span<const Arguments> points, Vec4f* results);
Vec4f execute_checker(const Arguments& arguments);
Vec4f execute_gradient(uint8_t variant, const Arguments& arguments);
Vec4f execute_brick(uint8_t variant, const Arguments& arguments, const float* data);
Vec4f execute_wave(uint8_t variant, const Arguments& arguments);
Vec4f execute_magic(uint8_t variant, const Arguments& arguments);
// Outputs of the Voronoi node. Distance and colour come together, the distance in w.
enum class VoronoiOutput : uint8_t { kColorAndDistance, kPosition };
// data: dimensions, feature, metric, normalize.
Vec4f execute_voronoi(uint8_t variant, const Arguments& arguments, const float* data);
Vec4f execute_white_noise(uint8_t variant, const Arguments& arguments);

}  // namespace vernier
