// Rotations and mappings of vectors (Cycles: kernel/svm/mapping_util.h, vector_rotate.h).
#pragma once

#include <cstdint>

#include "math/vec.h"

namespace vernier {

// In the order of the nodes' enum items.
enum class MappingKind : uint8_t { kPoint, kTexture, kVector, kNormal };
Vec3f map_vector(MappingKind kind, Vec3f v, Vec3f location, Vec3f rotation, Vec3f scale);

enum class RotationKind : uint8_t { kAxisAngle, kX, kY, kZ, kEuler };
// `angle_or_sign`: the angle in radians; for kEuler the sign, negative for the inverse rotation.
Vec3f rotate_vector(RotationKind kind, Vec3f v, Vec3f center, Vec3f axis_or_euler,
                    float angle_or_sign);

// Rotation about a unit axis (Rodrigues' formula).
Vec3f rotate_around(Vec3f v, Vec3f axis, float angle);

}  // namespace vernier
