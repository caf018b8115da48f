// What a ray met: everything that a material program may read.
#pragma once

#include <cstdint>

#include "math/frame.h"
#include "math/vec.h"

namespace vernier {

class Scene;

// The kind of ray that arrived, as Blender's Light Path node names it. A combination of bits.
enum RayFlags : uint32_t {
  kRayCamera = 1u << 0,
  kRayShadow = 1u << 1,
  kRayDiffuse = 1u << 2,
  kRayGlossy = 1u << 3,
  kRaySingular = 1u << 4,  // the last bounce was perfectly specular
  kRayReflection = 1u << 5,
  kRayTransmission = 1u << 6,
};

// Depths of the path so far, as the Light Path node counts them.
struct PathDepth {
  uint16_t total = 0, diffuse = 0, glossy = 0, transmission = 0, transparent = 0;
};

inline constexpr uint32_t kNoIndex = 0xffffffffu;

// A point on a surface (or, with instance == kNoIndex, a direction of the world, or a lamp).
struct SurfacePoint {
  const Scene* scene = nullptr;
  Vec3f p;        // position in render space: world minus Scene::origin(), metres
  Vec3f p_error;  // bound on the rounding error of p, per axis
  Vec3f ng;       // unit geometric normal, on the side of `wo`
  Vec3f ns;       // unit interpolated shading normal, on the same side of the surface as ng
  Vec3f wo;       // unit, back along the ray: toward the viewer (world: minus the ray's direction)
  float u = 0, v = 0;  // barycentric coordinates: p = (1-u-v) p0 + u p1 + v p2
  float ray_length = 0;
  uint32_t instance = kNoIndex, mesh = kNoIndex, triangle = kNoIndex, material = kNoIndex;
  uint32_t ray_flags = kRayCamera;
  PathDepth depth;
  bool backfacing = false;  // wo is on the back side of the surface as it is wound
};

}  // namespace vernier
