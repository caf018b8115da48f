#include "nodes/color_ops.h"

#include <array>

namespace vernier {
namespace {

Vec3f rgb_to_hsv(Color rgb) {
  const float value = max_component(rgb);
  const float delta = value - min_component(rgb);
  const float saturation = value != 0.0f ? delta / value : 0.0f;
  if (saturation == 0.0f) {
    return {0.0f, saturation, value};
  }
  const Vec3f c = (splat(value) - rgb) / splat(delta);
  float hue;
  if (rgb.x == value) {
    hue = c.z - c.y;
  } else if (rgb.y == value) {
    hue = 2.0f + c.x - c.z;
  } else {
    hue = 4.0f + c.y - c.x;
  }
  hue /= 6.0f;
  return {hue < 0.0f ? hue + 1.0f : hue, saturation, value};
}

Color hsv_to_rgb(Vec3f hsv) {
  const float s = hsv.y, v = hsv.z;
  if (s == 0.0f) {
    return splat(v);
  }
  const float h = (hsv.x == 1.0f ? 0.0f : hsv.x) * 6.0f;
  const float sector = std::floor(h);
  const float f = h - sector;
  const float p = v * (1.0f - s);
  const float q = v * (1.0f - s * f);
  const float t = v * (1.0f - s * (1.0f - f));
  if (sector == 0.0f) return {v, t, p};
  if (sector == 1.0f) return {q, v, p};
  if (sector == 2.0f) return {p, v, t};
  if (sector == 3.0f) return {p, q, v};
  if (sector == 4.0f) return {t, p, v};
  return {v, p, q};
}

Vec3f rgb_to_hsl(Color rgb) {
  const float hi = max_component(rgb);
  const float lo = min_component(rgb);
  const float lightness = std::min(1.0f, (hi + lo) / 2.0f);
  if (hi == lo) {
    return {0.0f, 0.0f, lightness};
  }
  const float delta = hi - lo;
  const float saturation = lightness > 0.5f ? delta / (2.0f - hi - lo) : delta / (hi + lo);
  float hue;
  if (hi == rgb.x) {
    hue = (rgb.y - rgb.z) / delta + (rgb.y < rgb.z ? 6.0f : 0.0f);
  } else if (hi == rgb.y) {
    hue = (rgb.z - rgb.x) / delta + 2.0f;
  } else {
    hue = (rgb.x - rgb.y) / delta + 4.0f;
  }
  return {hue / 6.0f, saturation, lightness};
}

Color hsl_to_rgb(Vec3f hsl) {
  const float h = hsl.x * 6.0f;
  const Vec3f n{saturate(std::abs(h - 3.0f) - 1.0f), saturate(2.0f - std::abs(h - 2.0f)),
                saturate(2.0f - std::abs(h - 4.0f))};
  const float chroma = (1.0f - std::abs(2.0f * hsl.z - 1.0f)) * hsl.y;
  return (n - splat(0.5f)) * chroma + splat(hsl.z);
}

float overlay(float t, float a, float b) {
  const float rest = 1.0f - t;
  return a < 0.5f ? a * (rest + 2.0f * t * b) : 1.0f - (rest + 2.0f * t * (1.0f - b)) * (1.0f - a);
}

float divide(float t, float a, float b) { return b != 0.0f ? (1.0f - t) * a + t * a / b : a; }

float dodge(float t, float a, float b) {
  if (a == 0.0f) {
    return 0.0f;
  }
  const float rest = 1.0f - t * b;
  return rest <= 0.0f ? 1.0f : std::min(a / rest, 1.0f);
}

float burn(float t, float a, float b) {
  const float rest = 1.0f - t + t * b;
  return rest <= 0.0f ? 0.0f : saturate(1.0f - (1.0f - a) / rest);
}

template <typename F>
Color map(F f, float t, Color a, Color b) {
  return {f(t, a.x, b.x), f(t, a.y, b.y), f(t, a.z, b.z)};
}

// a + t (b - a), which unlike lerp() is a where b is a.
Color interpolate(Color a, Color b, float t) { return a + (b - a) * t; }

Color blend_hue(float t, Color a, Color b, bool with_saturation) {
  const Vec3f other = rgb_to_hsv(b);
  if (other.y == 0.0f) {
    return a;
  }
  Vec3f hsv = rgb_to_hsv(a);
  hsv.x = other.x;
  if (with_saturation) {
    hsv.y = other.y;
  }
  return interpolate(a, hsv_to_rgb(hsv), t);
}

Color blend_saturation(float t, Color a, Color b) {
  Vec3f hsv = rgb_to_hsv(a);
  if (hsv.y == 0.0f) {
    return a;
  }
  hsv.y = lerp(hsv.y, rgb_to_hsv(b).y, t);
  return hsv_to_rgb(hsv);
}

Color blend_value(float t, Color a, Color b) {
  Vec3f hsv = rgb_to_hsv(a);
  hsv.z = lerp(hsv.z, rgb_to_hsv(b).z, t);
  return hsv_to_rgb(hsv);
}

}  // namespace

Color blend(BlendMode mode, float t, Color a, Color b) {
  const Color one = splat(1.0f);
  const float rest = 1.0f - t;
  switch (mode) {
    case BlendMode::kMix:
      return lerp(a, b, t);
    case BlendMode::kDarken:
      return interpolate(a, min(a, b), t);
    case BlendMode::kMultiply:
      return a * (splat(rest) + b * t);
    case BlendMode::kBurn:
      return map(burn, t, a, b);
    case BlendMode::kLighten:
      return interpolate(a, max(a, b), t);
    case BlendMode::kScreen:
      return one - (splat(rest) + (one - b) * t) * (one - a);
    case BlendMode::kDodge:
      return map(dodge, t, a, b);
    case BlendMode::kAdd:
      return a + b * t;
    case BlendMode::kOverlay:
      return map(overlay, t, a, b);
    case BlendMode::kSoftLight: {
      const Color screen = one - (one - b) * (one - a);
      return a * rest + ((one - a) * b * a + a * screen) * t;
    }
    case BlendMode::kLinearLight:
      return a + (b * 2.0f - one) * t;
    case BlendMode::kDifference:
      return interpolate(a, abs(a - b), t);
    case BlendMode::kExclusion:
      return max(interpolate(a, a + b - a * b * 2.0f, t), Color{});
    case BlendMode::kSubtract:
      return a - b * t;
    case BlendMode::kDivide:
      return map(divide, t, a, b);
    case BlendMode::kHue:
      return blend_hue(t, a, b, false);
    case BlendMode::kSaturation:
      return blend_saturation(t, a, b);
    case BlendMode::kColor:
      return blend_hue(t, a, b, true);
    case BlendMode::kValue:
      return blend_value(t, a, b);
  }
  return {};
}

Color to_rgb(ColorModel model, Vec3f value) {
  switch (model) {
    case ColorModel::kRgb:
      return value;
    case ColorModel::kHsv:
      return hsv_to_rgb(value);
    case ColorModel::kHsl:
      return hsl_to_rgb(value);
  }
  return {};
}

Vec3f from_rgb(ColorModel model, Color rgb) {
  switch (model) {
    case ColorModel::kRgb:
      return rgb;
    case ColorModel::kHsv:
      return rgb_to_hsv(rgb);
    case ColorModel::kHsl:
      return rgb_to_hsl(rgb);
  }
  return {};
}

Color adjust_hsv(Color color, float hue, float saturation, float value, float factor) {
  Vec3f hsv = rgb_to_hsv(color);
  hsv.x += hue + 0.5f;  // 0.5 is the node's neutral hue
  hsv.x -= std::floor(hsv.x);
  hsv.y = saturate(hsv.y * saturation);
  hsv.z *= value;
  return max(hsv_to_rgb(hsv) * factor + color * (1.0f - factor), Color{});
}

Color adjust_brightness_contrast(Color color, float brightness, float contrast) {
  return max(color * (1.0f + contrast) + splat(brightness - contrast * 0.5f), Color{});
}

Color apply_gamma(Color color, float gamma) {
  if (gamma == 0.0f) {
    return splat(1.0f);
  }
  for (int i = 0; i < 3; ++i) {
    if (color[i] > 0.0f) {
      color[i] = std::pow(color[i], gamma);
    }
  }
  return color;
}

// Piecewise fits of Planckian chromaticities with the coefficients of Cycles (kernel/tables.h):
// red and green are a/T + b T + c, blue is a cubic, on seven intervals from 800 K to 12000 K.
Color blackbody(float kelvin) {
  struct Fit {
    float from;
    std::array<float, 3> red, green;
    std::array<float, 4> blue;
  };
  static constexpr std::array<Fit, 7> kFits{{
      {6365.0f,
       {3.78717450e+03f, 9.35907826e-06f, 3.99075871e-01f},
       {-5.00799571e+02f, -4.59832026e-06f, 1.09098763e+00f},
       {6.72650283e-13f, -2.73078809e-08f, 4.24098264e-04f, -7.52335691e-01f}},
      {3315.0f,
       {4.59509185e+03f, 2.87495649e-05f, 1.50345020e-01f},
       {-1.17554822e+03f, -2.16378048e-05f, 1.30408023e+00f},
       {-1.61997957e-13f, -1.64216008e-08f, 3.86216271e-04f, -7.38077418e-01f}},
      {1902.0f,
       {4.67028036e+03f, 2.91258199e-05f, 1.26703442e-01f},
       {-1.42529332e+03f, -4.01150431e-05f, 1.43972784e+00f},
       {-1.97075738e-11f, 1.75359352e-07f, -2.50542825e-04f, -2.22783266e-02f}},
      {1449.0f,
       {4.09461742e+03f, -1.27446582e-04f, 7.25731635e-01f},
       {-1.26571316e+03f, 4.87340896e-06f, 1.27054498e+00f},
       {-3.61460868e-11f, 2.84822009e-07f, -4.93211319e-04f, 1.56723440e-01f}},
      {1167.0f,
       {3.34143193e+03f, -4.86551192e-04f, 1.76486769e+00f},
       {-1.02363977e+03f, 1.20223470e-04f, 9.36662319e-01f},
       {-1.40949732e-11f, 1.89878968e-07f, -3.56632824e-04f, 9.10767778e-02f}},
      {965.0f,
       {2.48845471e+03f, -1.11330907e-03f, 3.22621544e+00f},
       {-7.55994277e+02f, 3.16730098e-04f, 4.78306139e-01f},
       {2.40430366e-11f, 5.55021075e-08f, -1.98503712e-04f, 2.89312858e-02f}},
      {800.0f,
       {1.61919106e+03f, -2.05010916e-03f, 5.02995757e+00f},
       {-4.88999748e+02f, 6.04330754e-04f, -7.55807526e-02f},
       {5.96945309e-11f, -4.85742887e-08f, -9.70622247e-05f, -4.07936148e-03f}},
  }};
  if (kelvin >= 12000.0f) {
    return {0.8262954810f, 0.9945080502f, 1.5663077103f};
  }
  for (const Fit& fit : kFits) {
    if (kelvin >= fit.from) {
      const float inverse = 1.0f / kelvin;
      return max(
          {fit.red[0] * inverse + fit.red[1] * kelvin + fit.red[2],
           fit.green[0] * inverse + fit.green[1] * kelvin + fit.green[2],
           ((fit.blue[0] * kelvin + fit.blue[1]) * kelvin + fit.blue[2]) * kelvin + fit.blue[3]},
          Color{});
    }
  }
  return {5.4132944902f, 0.0f, 0.0f};
}

Vec4f lookup_table(std::span<const float> rows, float t, bool interpolate_rows, bool extrapolate) {
  const auto last = static_cast<int>(rows.size() / 4) - 1;
  const auto row = [&](int i) {
    const float* v = rows.data() + 4 * i;
    return Vec4f{v[0], v[1], v[2], v[3]};
  };
  if (extrapolate && last > 0 && (t < 0.0f || t > 1.0f)) {
    const Vec4f end = t < 0.0f ? row(0) : row(last);
    const Vec4f next = t < 0.0f ? row(1) : row(last - 1);
    const float distance = (t < 0.0f ? -t : t - 1.0f) * static_cast<float>(last);
    return end + (end + next * -1.0f) * distance;
  }
  // NaN falls to the first row.
  const float position = t > 0.0f ? std::min(t, 1.0f) * static_cast<float>(last) : 0.0f;
  const int i = static_cast<int>(position);
  const float fraction = position - static_cast<float>(i);
  if (!interpolate_rows || fraction == 0.0f) {
    return row(i);
  }
  return row(i) * (1.0f - fraction) + row(i + 1) * fraction;
}

}  // namespace vernier
