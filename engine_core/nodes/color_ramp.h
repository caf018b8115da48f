// Blender's colour ramp, as a table.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace vernier {

// In the order of ColorRamp's enum items.
enum class RampInterpolation : uint8_t { kLinear, kEase, kBSpline, kCardinal, kConstant };
enum class RampMode : uint8_t { kRgb, kHsv, kHsl };
enum class HueInterpolation : uint8_t { kNear, kFar, kClockwise, kCounterclockwise };

struct RampStyle {
  RampInterpolation interpolation = RampInterpolation::kLinear;
  RampMode mode = RampMode::kRgb;
  HueInterpolation hue = HueInterpolation::kNear;
};

// Rows that Cycles samples a ramp at, and so the resolution of its edges.
inline constexpr int kRampRows = 257;

// RGBA of the ramp at kRampRows equal steps over [0, 1]. `stops` holds rows (position, r, g, b, a),
// at least one; they are put in order of position.
std::vector<float> sample_ramp(std::span<const float> stops, const RampStyle& style);

}  // namespace vernier
