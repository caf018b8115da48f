// Uniform sampling of the solid angle of a rectangle (Urena, Fajardo and King 2013, "An
// Area-Preserving Parametrization for Spherical Rectangles").
#pragma once

#include "math/vec.h"

namespace vernier {

// A rectangle [x0, x1] x [y0, y1] in the plane at `z` < 0 of a frame at the receiver.
class SphericalRectangle {
 public:
  SphericalRectangle(float x0, float x1, float y0, float y1, float z)
      : x0_(x0), x1_(x1), y0_(y0), y1_(y1), z_(z) {
    // z components of the normals of the planes through the receiver and each edge.
    const float n0 = -y0 / std::sqrt(y0 * y0 + z * z);
    const float n1 = x1 / std::sqrt(x1 * x1 + z * z);
    const float n2 = y1 / std::sqrt(y1 * y1 + z * z);
    const float n3 = -x0 / std::sqrt(x0 * x0 + z * z);
    b0_ = n0;
    b1_ = n2;
    // The angle sum less 2 pi by arc sines instead of arc cosines: nothing large cancels.
    g23_ = arc_sine(-n2 * n3) + arc_sine(-n3 * n0);
    solid_angle_ = -(arc_sine(-n0 * n1) + arc_sine(-n1 * n2) + g23_);
  }

  float solid_angle() const { return solid_angle_; }

  // The offset from the receiver to the sampled point, in the frame.
  Vec3f sample(Vec2f u) const {
    // Equation 8 of the paper with its constant k folded in: au here is the paper's less pi, which
    // turns the signs of its sine and cosine.
    const float au = u.x * solid_angle_ + g23_;
    const float fu = (std::cos(au) * b0_ + b1_) / std::sin(au);
    const float cu = std::copysign(1.0f / std::sqrt(fu * fu + b0_ * b0_), fu);
    const float sine2 = 1.0f - cu * cu;
    const float xu =
        sine2 > 0.0f ? clamp(-(cu * z_) / std::sqrt(sine2), x0_, x1_) : (cu > 0.0f ? x1_ : x0_);
    const float d2 = xu * xu + z_ * z_;
    const float h0 = y0_ / std::sqrt(d2 + y0_ * y0_);
    const float h1 = y1_ / std::sqrt(d2 + y1_ * y1_);
    const float hv = h0 + u.y * (h1 - h0);
    const float rest = 1.0f - hv * hv;
    const float yv =
        rest > 0.0f ? clamp(hv * std::sqrt(d2 / rest), y0_, y1_) : (hv > 0.0f ? y1_ : y0_);
    return {xu, yv, z_};
  }

 private:
  static float arc_sine(float x) { return std::asin(clamp(x, -1.0f, 1.0f)); }

  float x0_, x1_, y0_, y1_, z_;
  float b0_, b1_, g23_, solid_angle_;
};

}  // namespace vernier
