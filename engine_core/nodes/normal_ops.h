// Perturbed normals and tangents (Cycles: kernel/svm/displace.h, tex_coord.h).
#pragma once

#include <cstdint>

#include "math/vec.h"
#include "scene/surface_point.h"

namespace vernier {

// In the order of the node's enum items.
enum class NormalSpace : uint8_t { kTangent, kObject, kWorld, kBlenderObject, kBlenderWorld };
// `color` encodes the normal in [0, 1]; `tangent_attribute` is read in tangent space alone.
Vec3f normal_map(NormalSpace space, const SurfacePoint& point, Color color, float strength,
                 uint32_t tangent_attribute);

// Heights at the point and `step` metres along its two shift axes, scaled to metres by `distance`.
struct BumpHeights {
  float center, x, y;
};
Vec3f bump_normal(const SurfacePoint& point, Vec3f normal, const BumpHeights& heights,
                  float strength, float distance, float step);

enum class TangentAxis : uint8_t { kX, kY, kZ };
Vec3f radial_tangent(TangentAxis axis, const SurfacePoint& point);
Vec3f uv_tangent(const SurfacePoint& point, uint32_t tangent_attribute);

}  // namespace vernier
