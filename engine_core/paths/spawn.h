// Rays that leave surfaces without meeting them again.
#pragma once

#include "embree/intersector.h"
#include "lights/light_sample.h"
#include "math/vec.h"
#include "scene/surface_point.h"

namespace vernier {

// Moves p off the surface by the bound of its rounding error, to the side that `w` points to, and
// on by the rounding of the result, so that the true surface cannot lie between
// (Pharr, Jakob and Humphreys 2023, section 6.8.6). No length is chosen: the bound scales with
// the coordinates.
inline Vec3f offset_origin(Vec3f p, Vec3f p_error, Vec3f ng, Vec3f w) {
  const float d = dot(abs(ng), p_error);
  const float side = dot(w, ng) < 0.0f ? -1.0f : 1.0f;
  const Vec3f q = p + ng * (side * d);
  // A whole unit in the last place of each component, along the normal: the sum rounds by half.
  return q + ng * (side * 2.0f * kUnitRoundoff * dot(abs(ng), abs(q)));
}

// The ray from a surface point in direction `d`.
inline Ray spawn_ray(const SurfacePoint& from, Vec3f d) {
  return {offset_origin(from.p, from.p_error, from.ng, d), d, kInfinity};
}

// The end of a segment from `from` to the surface point p, on the side of it that `back` points to.
// A ray meets the plane of p with an error of the size of its way there, which may be far larger
// than that of p: it must end before all of that. (The intersection is a quotient of dot products
// with differences to the ray's origin, each good to some 4 roundings, and p itself lies off the
// plane by its own error; 16 leave room.)
inline Vec3f segment_end(Vec3f from, Vec3f p, Vec3f p_error, Vec3f ng, Vec3f back) {
  const float way = max_component(abs(from - p));
  return offset_origin(p, p_error + splat(gamma(16) * way), ng, back);
}

// The segment between two surface points. `wi` is the unit direction with which light is scattered
// at both: each end lies on the side of its surface that scattering there was told of. (Where the
// segment runs along a wall, rounding may see it on either side: if the ends did not keep to what
// was seen, light would pass from one side of the wall to the other.)
inline Ray spawn_segment(const SurfacePoint& from, const SurfacePoint& to, Vec3f wi) {
  const Vec3f o = offset_origin(from.p, from.p_error, from.ng, wi);
  return {o, segment_end(o, to.p, to.p_error, to.ng, -wi) - o, kOneMinusEpsilon};
}

// The segment from a point in free space to a surface point, `back` the direction from there.
inline Ray spawn_segment(Vec3f from, const SurfacePoint& to, Vec3f back) {
  return {from, segment_end(from, to.p, to.p_error, to.ng, back) - from, kOneMinusEpsilon};
}

// The ray from a surface point to a light, ending just before it.
inline Ray spawn_shadow_ray(const SurfacePoint& from, const LightSample& light) {
  const Vec3f o = offset_origin(from.p, from.p_error, from.ng, light.wi);
  if (!(light.distance < kInfinity)) {
    return {o, light.wi, kInfinity};
  }
  return {o, segment_end(o, light.p, light.p_error, light.n, o - light.p) - o, kOneMinusEpsilon};
}

}  // namespace vernier
