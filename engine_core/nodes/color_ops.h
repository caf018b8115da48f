// Colour arithmetic: blend modes, colour models, adjustments, blackbody light, ramps and curves.
// Definitions as in Cycles (kernel/svm/color_util.h, hsv.h, ramp.h, math_util.h; util/color.h).
#pragma once

#include <cstdint>
#include <span>

#include "math/vec.h"

namespace vernier {

// In the order of the node's enum items.
enum class BlendMode : uint8_t {
  kMix,
  kDarken,
  kMultiply,
  kBurn,
  kLighten,
  kScreen,
  kDodge,
  kAdd,
  kOverlay,
  kSoftLight,
  kLinearLight,
  kDifference,
  kExclusion,
  kSubtract,
  kDivide,
  kHue,
  kSaturation,
  kColor,
  kValue,
};
Color blend(BlendMode mode, float factor, Color a, Color b);

enum class ColorModel : uint8_t { kRgb, kHsv, kHsl };
Color to_rgb(ColorModel model, Vec3f value);
Vec3f from_rgb(ColorModel model, Color rgb);

Color adjust_hsv(Color color, float hue, float saturation, float value, float factor);
Color adjust_brightness_contrast(Color color, float brightness, float contrast);
Color apply_gamma(Color color, float gamma);
inline Color invert(Color color, float factor) {
  return (splat(1.0f) - color) * factor + color * (1.0f - factor);
}

// Luminance as Blender converts colours to values: that of its configuration's Rec.709 primaries.
inline float socket_luminance(Color c) {
  return 0.2126390059f * c.x + 0.7151686788f * c.y + 0.0721923154f * c.z;
}

// Colour of a black body, linear Rec.709 scaled to luminance 1; temperature in kelvin.
Color blackbody(float kelvin);

// Tables of 4 floats a row over [0, 1]. Outside: the end rows, or their slope where `extrapolate`.
Vec4f lookup_table(std::span<const float> rows, float t, bool interpolate, bool extrapolate);

}  // namespace vernier
