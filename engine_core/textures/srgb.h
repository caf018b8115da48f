// The sRGB transfer function (IEC 61966-2-1), by table.
#pragma once

#include <array>
#include <cmath>

namespace vernier {

// Linear interpolation between knots at all byte values and three between each two of them: exact
// at bytes, elsewhere within 5e-5 of the value.
class SrgbTable {
 public:
  static constexpr int kIntervals = 255 * 4;

  SrgbTable() {
    for (int i = 0; i <= kIntervals; ++i) {
      values_[static_cast<size_t>(i)] =
          static_cast<float>(decode(static_cast<double>(i) / kIntervals));
    }
    values_[kIntervals + 1] = 1.0f;
  }

  float operator()(float c) const {
    const float x = c * static_cast<float>(kIntervals);
    const auto i = static_cast<size_t>(x);
    return values_[i] + (x - static_cast<float>(i)) * (values_[i + 1] - values_[i]);
  }

  static double decode(double c) {
    return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
  }

 private:
  std::array<float, kIntervals + 2> values_;
};

inline const SrgbTable kSrgbTable;

// Any value: negative ones are black, as in Cycles; those above 1 follow the curve.
inline float srgb_to_linear(float c) {
  if (c >= 0.0f && c <= 1.0f) {
    return kSrgbTable(c);
  }
  return c > 1.0f ? static_cast<float>(SrgbTable::decode(static_cast<double>(c))) : 0.0f;
}

}  // namespace vernier
