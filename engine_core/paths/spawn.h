// Rays that leave surfaces without meeting them again.
#pragma once

#include <bit>

#include "embree/intersector.h"
#include "lights/light_sample.h"
#include "math/vec.h"
#include "scene/surface_point.h"

namespace vernier {

// Moves p off the surface by the bound of its rounding error, to the side that `w` points to, and
// on to the next float outward, so that the true surface cannot lie between
// (Pharr, Jakob and Humphreys 2023, section 6.8.6). No length is chosen: the bound scales with
// the coordinates.
inline Vec3f offset_origin(Vec3f p, Vec3f p_error, Vec3f ng, Vec3f w) {
  const float d = dot(abs(ng), p_error);
  const Vec3f offset = ng * (dot(w, ng) < 0.0f ? -d : d);
  Vec3f q = p + offset;
  for (int i = 0; i < 3; ++i) {
    if (offset[i] > 0.0f) {
      q[i] = std::nextafter(q[i], kInfinity);
    } else if (offset[i] < 0.0f) {
      q[i] = std::nextafter(q[i], -kInfinity);
    }
  }
  return q;
}

// The ray from a surface point in direction `d`.
inline Ray spawn_ray(const SurfacePoint& from, Vec3f d) {
  return {offset_origin(from.p, from.p_error, from.ng, d), d, kInfinity};
}

// The ray from a surface point to a light, ending just before it.
inline Ray spawn_shadow_ray(const SurfacePoint& from, const LightSample& light) {
  const Vec3f o = offset_origin(from.p, from.p_error, from.ng, light.wi);
  if (!(light.distance < kInfinity)) {
    return {o, light.wi, kInfinity};
  }
  const Vec3f target = offset_origin(light.p, light.p_error, light.n, -light.wi);
  return {o, target - o, kOneMinusEpsilon};
}

}  // namespace vernier
