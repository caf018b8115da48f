// Orthonormal frames.
#pragma once

#include "math/vec.h"

namespace vernier {

// Right-handed orthonormal basis (s, t, n). In local coordinates the normal is +z.
struct Frame {
  Vec3f s{1, 0, 0}, t{0, 1, 0}, n{0, 0, 1};

  Frame() = default;
  Frame(Vec3f s_, Vec3f t_, Vec3f n_) : s(s_), t(t_), n(n_) {}

  // A frame about a unit normal, without a branch or a singularity
  // (Duff et al. 2017, "Building an Orthonormal Basis, Revisited").
  explicit Frame(Vec3f normal) : n(normal) {
    const float sign = std::copysign(1.0f, n.z);
    const float a = -1.0f / (sign + n.z);
    const float b = n.x * n.y * a;
    s = {1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x};
    t = {b, sign + n.y * n.y * a, -n.y};
  }

  // A frame about a unit normal whose s lies in the plane of `normal` and `tangent`;
  // where these are parallel, any frame about the normal.
  Frame(Vec3f normal, Vec3f tangent) : n(normal) {
    const Vec3f c = cross(normal, tangent);
    const float length2 = length_squared(c);
    if (!(length2 > square(gamma(8)) * length_squared(tangent))) {
      *this = Frame(normal);
      return;
    }
    t = c * (1.0f / std::sqrt(length2));
    s = cross(t, n);
  }

  Vec3f to_local(Vec3f v) const { return {dot(v, s), dot(v, t), dot(v, n)}; }
  Vec3f to_world(Vec3f v) const { return s * v.x + t * v.y + n * v.z; }
};

}  // namespace vernier
