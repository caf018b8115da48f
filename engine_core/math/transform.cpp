#include "math/transform.h"

namespace vernier {

Transform inverse(const Transform& t) {
  const auto d = [&t](size_t i) { return static_cast<double>(t.m[i]); };
  const double det = t.determinant();
  Transform r;
  if (det == 0.0 || !std::isfinite(det)) {
    r.m.fill(0.0f);
    return r;
  }
  const double inv[9] = {
      (d(5) * d(10) - d(6) * d(9)) / det, (d(2) * d(9) - d(1) * d(10)) / det,
      (d(1) * d(6) - d(2) * d(5)) / det,  (d(6) * d(8) - d(4) * d(10)) / det,
      (d(0) * d(10) - d(2) * d(8)) / det, (d(2) * d(4) - d(0) * d(6)) / det,
      (d(4) * d(9) - d(5) * d(8)) / det,  (d(1) * d(8) - d(0) * d(9)) / det,
      (d(0) * d(5) - d(1) * d(4)) / det,
  };
  for (size_t row = 0; row < 3; ++row) {
    double offset = 0.0;
    for (size_t col = 0; col < 3; ++col) {
      r.m[4 * row + col] = static_cast<float>(inv[3 * row + col]);
      offset -= inv[3 * row + col] * d(4 * col + 3);
    }
    r.m[4 * row + 3] = static_cast<float>(offset);
  }
  return r;
}

Transform operator*(const Transform& a, const Transform& b) {
  Transform r;
  for (size_t row = 0; row < 3; ++row) {
    for (size_t col = 0; col < 4; ++col) {
      double sum = col == 3 ? static_cast<double>(a.m[4 * row + 3]) : 0.0;
      for (size_t k = 0; k < 3; ++k) {
        sum += static_cast<double>(a.m[4 * row + k]) * static_cast<double>(b.m[4 * k + col]);
      }
      r.m[4 * row + col] = static_cast<float>(sum);
    }
  }
  return r;
}

}  // namespace vernier
