#include "nodes/vector_ops.h"

#include "math/transform.h"
#include "nodes/math_ops.h"

namespace vernier {
namespace {

// Rotation about x, then y, then z.
Transform euler_rotation(Vec3f euler) {
  const float cx = std::cos(euler.x), cy = std::cos(euler.y), cz = std::cos(euler.z);
  const float sx = std::sin(euler.x), sy = std::sin(euler.y), sz = std::sin(euler.z);
  Transform t;
  t.m = {cy * cz,
         sy * sx * cz - cx * sz,
         sy * cx * cz + sx * sz,
         0.0f,
         cy * sz,
         sy * sx * sz + cx * cz,
         sy * cx * sz - sx * cz,
         0.0f,
         -sy,
         cy * sx,
         cy * cx,
         0.0f};
  return t;
}

}  // namespace

Vec3f map_vector(MappingKind kind, Vec3f v, Vec3f location, Vec3f rotation, Vec3f scale) {
  const Transform rotate = euler_rotation(rotation);
  switch (kind) {
    case MappingKind::kPoint:
      return rotate.vector(v * scale) + location;
    case MappingKind::kTexture:
      return safe_divide(rotate.transposed_vector(v - location), scale);
    case MappingKind::kVector:
      return rotate.vector(v * scale);
    case MappingKind::kNormal:
      return normalize(rotate.vector(safe_divide(v, scale)));
  }
  return {};
}

Vec3f rotate_around(Vec3f v, Vec3f axis, float angle) {
  const float c = std::cos(angle), s = std::sin(angle);
  return v * c + cross(axis, v) * s + axis * (dot(axis, v) * (1.0f - c));
}

Vec3f rotate_vector(RotationKind kind, Vec3f v, Vec3f center, Vec3f axis_or_euler,
                    float angle_or_sign) {
  const Vec3f arm = v - center;
  switch (kind) {
    case RotationKind::kAxisAngle: {
      const float size = length(axis_or_euler);
      return size != 0.0f ? rotate_around(arm, axis_or_euler / size, angle_or_sign) + center : v;
    }
    case RotationKind::kX:
      return rotate_around(arm, {1, 0, 0}, angle_or_sign) + center;
    case RotationKind::kY:
      return rotate_around(arm, {0, 1, 0}, angle_or_sign) + center;
    case RotationKind::kZ:
      return rotate_around(arm, {0, 0, 1}, angle_or_sign) + center;
    case RotationKind::kEuler: {
      const Transform rotate = euler_rotation(axis_or_euler);
      return (angle_or_sign < 0.0f ? rotate.transposed_vector(arm) : rotate.vector(arm)) + center;
    }
  }
  return v;
}

}  // namespace vernier
