// How much light passes along a segment.
#pragma once

#include "nodes/material.h"
#include "paths/spawn.h"
#include "scene/scene.h"

namespace vernier {

// What the segments of a path share.
struct SegmentContext {
  const Scene& scene;
  int most_surfaces;  // of those that let light through, more than these block
  uint64_t& rays;
};

// Product of the straight transparency of the surfaces that `intersect(ray, hit)` finds along
// `ray`. `depth` and `flags` are what their materials may read of the path; `path_dependent`, where
// given, is set when one of them does read it. passed_one(Color) is told of each one's
// transparency.
template <class Intersect, class Passed>
Color pass_surfaces(const SegmentContext& context, Ray ray, const PathDepth& depth, uint32_t flags,
                    bool* path_dependent, const Intersect& intersect, const Passed& passed_one) {
  const Scene& scene = context.scene;
  Color result = splat(1.0f);
  const Vec3f end = ray.o + ray.d * ray.t_max;
  const bool finite = ray.t_max < kInfinity;
  PathDepth here = depth;
  Hit hit;
  for (int passed = 0; ++context.rays, intersect(ray, hit); ++passed) {
    if (passed >= context.most_surfaces) {
      return {};
    }
    SurfacePoint point = scene.surface_point(ray, hit);
    point.ray_flags = flags;
    point.depth = here;
    const Material& material = *scene.materials[point.material];
    if (path_dependent != nullptr && material.traits().path_dependent) {
      *path_dependent = true;
    }
    const Color transparency = material.transparency(point);
    passed_one(transparency);
    result *= transparency;
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
  return result;
}

// Transmittance of the segment `ray` for shadows: 0 behind opaque surfaces, else the product of the
// transparency of those on the way.
template <bool Transparent>
Color transmittance(const SegmentContext& context, const Ray& ray, const PathDepth& depth,
                    bool* path_dependent = nullptr) {
  ++context.rays;
  if (context.scene.occluded_by_opaque(ray)) {
    return {};
  }
  if constexpr (Transparent) {
    return pass_surfaces(
        context, ray, depth, kRayShadow, path_dependent,
        [&](const Ray& r, Hit& hit) { return context.scene.intersect_transparent(r, hit); },
        [](Color) {});
  }
  return splat(1.0f);
}

// The same for the camera's own view, along a segment that starts at its lens: what is hidden from
// the camera or from shadows is so for it alone.
template <bool Transparent>
Color camera_transmittance(const SegmentContext& context, const Ray& ray, bool* path_dependent) {
  if (!context.scene.requirements.hidden_from_rays) {
    return transmittance<Transparent>(context, ray, PathDepth{}, path_dependent);
  }
  return pass_surfaces(
      context, ray, PathDepth{}, kRayCamera, path_dependent,
      [&](const Ray& r, Hit& hit) { return context.scene.intersect(r, kVisibleCamera, hit); },
      [](Color) {});
}

}  // namespace vernier
