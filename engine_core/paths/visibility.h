// How much light passes along a shadow ray.
#pragma once

#include "nodes/material.h"
#include "paths/spawn.h"
#include "scene/scene.h"

namespace vernier {

// Transmittance of the segment `ray`: 0 behind opaque surfaces, else the product of the straight
// transparency of the surfaces on the way, of which more than `most_surfaces` block.
// `depth` is what transparent materials may read of the path.
template <bool Transparent>
Color transmittance(const Scene& scene, Ray ray, const PathDepth& depth, int most_surfaces,
                    uint64_t& rays) {
  ++rays;
  if (scene.occluded_by_opaque(ray)) {
    return {};
  }
  Color result = splat(1.0f);
  if constexpr (Transparent) {
    const Vec3f end = ray.o + ray.d * ray.t_max;
    const bool finite = ray.t_max < kInfinity;
    PathDepth here = depth;
    Hit hit;
    for (int passed = 0; ++rays, scene.intersect_transparent(ray, hit); ++passed) {
      if (passed >= most_surfaces) {
        return {};
      }
      SurfacePoint point = scene.surface_point(ray, hit);
      point.ray_flags = kRayShadow;
      point.depth = here;
      result *= scene.materials[point.material]->transparency(point);
      if (is_black(result)) {
        return {};
      }
      ++here.transparent;
      // Go on from the surface; a segment keeps its end.
      const Vec3f o = offset_origin(point.p, point.p_error, point.ng, ray.d);
      ray = finite ? Ray{o, end - o, 1.0f} : Ray{o, ray.d, kInfinity};
      if (finite && !(dot(ray.d, point.wo) < 0.0f)) {
        break;  // the step off the surface reached the end
      }
    }
  }
  return result;
}

}  // namespace vernier
