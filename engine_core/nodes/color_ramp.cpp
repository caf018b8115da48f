#include "nodes/color_ramp.h"

#include <algorithm>
#include <array>

#include "nodes/color_ops.h"

namespace vernier {
namespace {

struct Stop {
  float position;
  Vec4f color;
};

// Weights of four stops in a row, from the farther right one to the farther left one; t runs from
// the nearer right one to the nearer left one.
std::array<float, 4> spline_weights(RampInterpolation interpolation, float t) {
  const float t2 = t * t, t3 = t2 * t;
  if (interpolation == RampInterpolation::kCardinal) {
    constexpr float c = 0.71f;  // Blender's tension
    return {-c * t3 + 2.0f * c * t2 - c * t, (2.0f - c) * t3 + (c - 3.0f) * t2 + 1.0f,
            (c - 2.0f) * t3 + (3.0f - 2.0f * c) * t2 + c * t, c * t3 - c * t2};
  }
  return {(-t3 + 3.0f * t2 - 3.0f * t + 1.0f) / 6.0f, (3.0f * t3 - 6.0f * t2 + 4.0f) / 6.0f,
          (-3.0f * t3 + 3.0f * t2 + 3.0f * t + 1.0f) / 6.0f, t3 / 6.0f};
}

float blend_hue(HueInterpolation kind, float a, float b, float t) {
  a = a < 1.0f ? a : a - 1.0f;
  b = b < 1.0f ? b : b - 1.0f;
  const float difference = b - a;
  bool raise_a = false, raise_b = false;
  switch (kind) {
    case HueInterpolation::kNear:
      raise_a = difference > 0.5f;
      raise_b = difference < -0.5f;
      break;
    case HueInterpolation::kFar:
      raise_a = difference >= 0.0f && difference < 0.5f;
      raise_b = difference < 0.0f && difference > -0.5f;
      break;
    case HueInterpolation::kCounterclockwise:
      raise_b = a > b;
      break;
    case HueInterpolation::kClockwise:
      raise_a = a < b;
      break;
  }
  const float hue = lerp(raise_a ? a + 1.0f : a, raise_b ? b + 1.0f : b, t);
  return hue < 1.0f ? hue : hue - 1.0f;
}

// Between the colours of two neighbouring stops.
Vec4f blend_colors(const RampStyle& style, Vec4f a, Vec4f b, float t) {
  if (style.mode == RampMode::kRgb) {
    return a * (1.0f - t) + b * t;
  }
  const ColorModel model = style.mode == RampMode::kHsv ? ColorModel::kHsv : ColorModel::kHsl;
  const Vec3f x = from_rgb(model, a.xyz()), y = from_rgb(model, b.xyz());
  const Color rgb =
      to_rgb(model, {blend_hue(style.hue, x.x, y.x, t), lerp(x.y, y.y, t), lerp(x.z, y.z, t)});
  return {rgb.x, rgb.y, rgb.z, lerp(a.w, b.w, t)};
}

Vec4f evaluate(const std::vector<Stop>& stops, const RampStyle& style, float x) {
  // Only colours in RGB have splines.
  const RampInterpolation interpolation =
      style.mode == RampMode::kRgb ? style.interpolation : RampInterpolation::kLinear;
  const bool spline =
      interpolation == RampInterpolation::kBSpline || interpolation == RampInterpolation::kCardinal;
  const auto after = std::upper_bound(stops.begin(), stops.end(), x,
                                      [](float v, const Stop& s) { return v < s.position; });
  if (stops.size() == 1 || (!spline && (after == stops.begin() || x <= stops[0].position))) {
    return stops.front().color;
  }
  if (!spline && after == stops.end()) {
    return stops.back().color;
  }
  // Beyond the ends splines go on to copies of the end stops at 0 and 1.
  const auto a = static_cast<size_t>(after - stops.begin());
  const Stop right = a == stops.size() ? Stop{1.0f, stops.back().color} : stops[a];
  const Stop left = a == 0 ? Stop{0.0f, stops.front().color} : stops[a - 1];
  if (interpolation == RampInterpolation::kConstant) {
    return left.color;
  }
  float t = left.position != right.position
                ? (x - right.position) / (left.position - right.position)
                : (a != stops.size() ? 0.0f : 1.0f);
  if (spline) {
    const Stop& far_right = a + 1 >= stops.size() ? right : stops[a + 1];
    const Stop& far_left = a < 2 ? left : stops[a - 2];
    const std::array<float, 4> w = spline_weights(interpolation, saturate(t));
    const Vec4f c =
        far_right.color * w[0] + right.color * w[1] + left.color * w[2] + far_left.color * w[3];
    return {saturate(c.x), saturate(c.y), saturate(c.z), saturate(c.w)};
  }
  if (interpolation == RampInterpolation::kEase) {
    t = t * t * (3.0f - 2.0f * t);
  }
  return blend_colors(style, right.color, left.color, t);
}

}  // namespace

std::vector<float> sample_ramp(std::span<const float> values, const RampStyle& style) {
  std::vector<Stop> stops;
  for (size_t i = 0; i + 5 <= values.size(); i += 5) {
    stops.push_back({values[i], {values[i + 1], values[i + 2], values[i + 3], values[i + 4]}});
  }
  std::stable_sort(stops.begin(), stops.end(),
                   [](const Stop& a, const Stop& b) { return a.position < b.position; });
  std::vector<float> rows;
  rows.reserve(4 * kRampRows);
  for (int i = 0; i < kRampRows; ++i) {
    const Vec4f c = evaluate(stops, style, static_cast<float>(i) / (kRampRows - 1));
    rows.insert(rows.end(), {c.x, c.y, c.z, c.w});
  }
  return rows;
}

}  // namespace vernier
