// Affine transforms, and the bounds of what they do to rounded points.
#pragma once

#include <array>

#include "math/vec.h"

namespace vernier {

// A 3 by 4 affine matrix in row order: y = M x + c. Float32 entries, as Blender stores them.
struct Transform {
  std::array<float, 12> m{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

  Vec3f column(int c) const {
    const auto i = static_cast<size_t>(c);
    return {m[i], m[4 + i], m[8 + i]};
  }
  Vec3f translation() const { return {m[3], m[7], m[11]}; }

  Vec3f point(Vec3f p) const {
    return {m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3],
            m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
            m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]};
  }
  Vec3f vector(Vec3f v) const {
    return {m[0] * v.x + m[1] * v.y + m[2] * v.z, m[4] * v.x + m[5] * v.y + m[6] * v.z,
            m[8] * v.x + m[9] * v.y + m[10] * v.z};
  }
  // The transpose of the linear part times v: with the inverse transform this maps normals.
  Vec3f transposed_vector(Vec3f v) const {
    return {m[0] * v.x + m[4] * v.y + m[8] * v.z, m[1] * v.x + m[5] * v.y + m[9] * v.z,
            m[2] * v.x + m[6] * v.y + m[10] * v.z};
  }

  // Bound on the absolute rounding error of point(p) where p itself carries `error`
  // (Pharr, Jakob and Humphreys 2023, section 6.8.5).
  Vec3f point_error(Vec3f p, Vec3f error) const {
    Vec3f e;
    for (int r = 0; r < 3; ++r) {
      const auto i = static_cast<size_t>(4 * r);
      const float moved =
          std::abs(m[i]) * error.x + std::abs(m[i + 1]) * error.y + std::abs(m[i + 2]) * error.z;
      const float rounded = std::abs(m[i] * p.x) + std::abs(m[i + 1] * p.y) +
                            std::abs(m[i + 2] * p.z) + std::abs(m[i + 3]);
      e[r] = (1.0f + gamma(4)) * moved + gamma(4) * rounded;
    }
    return e;
  }

  double determinant() const {
    const auto d = [this](size_t i) { return static_cast<double>(m[i]); };
    return d(0) * (d(5) * d(10) - d(6) * d(9)) - d(1) * (d(4) * d(10) - d(6) * d(8)) +
           d(2) * (d(4) * d(9) - d(5) * d(8));
  }
  bool is_identity() const { return m == Transform{}.m; }

  bool operator==(const Transform&) const = default;
};

// The inverse, computed in float64. A singular matrix gives all zeros: callers test determinant().
Transform inverse(const Transform& t);
// a after b.
Transform operator*(const Transform& a, const Transform& b);

}  // namespace vernier
