// Microfibre sheen: a linearly transformed cosine (Zeltner, Burley and Chiang 2022, "Practical
// Multiple-Scattering Sheen Using Linearly Transformed Cosines").
#pragma once

#include "math/vec.h"

namespace vernier {

// The transform (x, y, z) -> (a x + b z, a y, z) to the clamped cosine, and the directional albedo.
struct SheenTransform {
  float a = 1.0f, b = 0.0f, albedo = 0.0f;
};

// At the cosine of the view and roughness in [0.001, 1].
SheenTransform sheen_transform(float cos_v, float roughness);

// Density at l in the frame where the view is (sin, 0, cos); it includes the cosine and
// integrates to 1 over the hemisphere.
inline float sheen_density(float a, float b, Vec3f l) {
  if (!(l.z > 0.0f)) {
    return 0.0f;
  }
  const float length2 = square(a * l.x + b * l.z) + square(a * l.y) + l.z * l.z;
  return kInvPi * l.z * square(a / length2);
}

// A direction of that density, from one of the cosine-weighted hemisphere.
inline Vec3f sheen_direction(float a, float b, Vec3f cosine) {
  return normalize(Vec3f{cosine.x - b * cosine.z, cosine.y, a * cosine.z});
}

}  // namespace vernier
