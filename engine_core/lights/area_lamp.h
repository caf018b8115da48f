// Area lamps: rectangles and ellipses that shine from one side.
//
// From each receiver one region of the lamp's plane is sampled: the lamp, or, where its spread is
// narrow, the smallest simple shape about the part of it that lights the receiver. The region
// depends on the receiver's position alone, so that a sample and the density of a ray that meets
// the lamp agree on it.
#pragma once

#include "lights/lamp.h"
#include "lights/light_sample.h"
#include "lights/spherical_rectangle.h"
#include "math/warp.h"

namespace vernier {

// What is sampled: a rectangle or an ellipse, in metres along the lamp's axes from its centre.
struct AreaRegion {
  float u0, u1, v0, v1;  // bounds
  bool ellipse;          // the ellipse in these bounds, by area
  float height;          // of the receiver above the lamp's plane, on the side it shines to
  float receiver_u, receiver_v;
};

// False where the lamp does not light the receiver.
inline bool area_region(const Lamp& lamp, Vec3f p, AreaRegion& region) {
  const Vec3f offset = p - lamp.center;
  region.height = dot(offset, lamp.axis);
  if (!(region.height > 0.0f)) {
    return false;
  }
  region.receiver_u = dot(offset, lamp.dual_u);
  region.receiver_v = dot(offset, lamp.dual_v);
  region.u0 = -lamp.half_u;
  region.u1 = lamp.half_u;
  region.v0 = -lamp.half_v;
  region.v1 = lamp.half_v;
  region.ellipse = lamp.ellipse;
  if (lamp.sheared || lamp.delta) {
    return true;
  }
  if (lamp.spreads) {
    // Only the disk about the receiver's foot on the lamp's plane reaches it.
    const float reach = region.height * lamp.tan_half_spread;
    AreaRegion clipped = region;
    clipped.u0 = std::max(region.u0, region.receiver_u - reach);
    clipped.u1 = std::min(region.u1, region.receiver_u + reach);
    clipped.v0 = std::max(region.v0, region.receiver_v - reach);
    clipped.v1 = std::min(region.v1, region.receiver_v + reach);
    clipped.ellipse = false;
    if (!(clipped.u0 < clipped.u1) || !(clipped.v0 < clipped.v1)) {
      return false;
    }
    const float rectangle = (clipped.u1 - clipped.u0) * (clipped.v1 - clipped.v0);
    const float disk = kPi * reach * reach;
    const float whole = lamp.ellipse ? kPi * lamp.half_u * lamp.half_v : kInfinity;
    if (lamp.ellipse && disk < rectangle && disk < whole) {
      region.u0 = region.receiver_u - reach;
      region.u1 = region.receiver_u + reach;
      region.v0 = region.receiver_v - reach;
      region.v1 = region.receiver_v + reach;
    } else if (rectangle < whole) {
      region = clipped;
    }
  }
  if (region.ellipse) {
    // Close by, the solid angle of the rectangle about it, less its corners, has by far the
    // smaller variance.
    const float su = region.u1 - region.u0;
    const float sv = region.v1 - region.v0;
    region.ellipse = square(region.height) > square(std::max(su, sv));
  }
  return true;
}

// Part of the lamp's radiance that leaves it along -wi (unit): what the soft box's grid lets pass.
inline float area_lamp_factor(const Lamp& lamp, Vec3f wi) {
  const float cosine = -dot(wi, lamp.axis);
  if (!(cosine > 0.0f)) {
    return 0.0f;
  }
  if (!lamp.spreads) {
    return 1.0f;
  }
  const float tangent = length(cross(wi, lamp.axis)) / cosine;
  return std::max(lamp.tan_half_spread - tangent, 0.0f) * lamp.normalize_spread;
}

inline bool area_contains(const Lamp& lamp, float u, float v) {
  return lamp.ellipse ? square(u / lamp.half_u) + square(v / lamp.half_v) <= 1.0f
                      : std::abs(u) <= lamp.half_u && std::abs(v) <= lamp.half_v;
}

// Area of a region; what the densities of points are the reciprocal of.
inline float region_area(const Lamp& lamp, const AreaRegion& region) {
  if (lamp.sheared) {
    return lamp.area;
  }
  return (region.u1 - region.u0) * (region.v1 - region.v0) * (region.ellipse ? kPi / 4.0f : 1.0f);
}

inline SphericalRectangle spherical_region(const AreaRegion& r) {
  return {r.u0 - r.receiver_u, r.u1 - r.receiver_u, r.v0 - r.receiver_v, r.v1 - r.receiver_v,
          -r.height};
}

inline float pdf_area_lamp(const Lamp& lamp, Vec3f p, Vec3f wi, float distance) {
  AreaRegion region;
  if (!area_region(lamp, p, region)) {
    return 0.0f;
  }
  if (!lamp.sheared && !region.ellipse) {
    const float solid_angle = spherical_region(region).solid_angle();
    if (solid_angle >= kSmallestSphericalSample) {
      return 1.0f / solid_angle;
    }
  }
  const float cosine = -dot(wi, lamp.axis);
  if (!(cosine > 0.0f)) {
    return 0.0f;
  }
  return bounded_density(distance * (distance / region_area(lamp, region)) / cosine);
}

inline bool sample_area_lamp(const Lamp& lamp, const Receiver& from, Vec2f u, ShapeSample& s) {
  AreaRegion region;
  if (!area_region(lamp, from.p, region)) {
    return false;
  }
  s.n = lamp.axis;
  if (lamp.delta) {
    if (!area_contains(lamp, region.receiver_u, region.receiver_v)) {
      return false;
    }
    s.wi = -lamp.axis;
    s.distance = region.height;
    s.p = from.p + s.wi * s.distance;
    s.pdf = 1.0f;
    s.factor = 1.0f;
    return true;
  }
  float lamp_u, lamp_v;  // on the lamp's plane, from its centre
  float pdf = 0.0f;      // solid angle; 0: of the area, which is converted below
  if (lamp.sheared) {
    const Vec2f q = lamp.ellipse ? square_to_disk(u) : Vec2f{2.0f * u.x - 1.0f, 2.0f * u.y - 1.0f};
    lamp_u = q.x * lamp.half_u;
    lamp_v = q.y * lamp.half_v;
  } else if (region.ellipse) {
    const Vec2f q = square_to_disk(u);
    lamp_u = 0.5f * (region.u0 + region.u1 + q.x * (region.u1 - region.u0));
    lamp_v = 0.5f * (region.v0 + region.v1 + q.y * (region.v1 - region.v0));
  } else {
    const SphericalRectangle rectangle = spherical_region(region);
    if (rectangle.solid_angle() >= kSmallestSphericalSample) {
      pdf = 1.0f / rectangle.solid_angle();
      const Vec3f q = rectangle.sample(u);
      lamp_u = q.x + region.receiver_u;
      lamp_v = q.y + region.receiver_v;
    } else {
      lamp_u = lerp(region.u0, region.u1, u.x);
      lamp_v = lerp(region.v0, region.v1, u.y);
    }
  }
  // A rectangle about an ellipse, or a disk of reach, may stick out of the lamp.
  if ((lamp.ellipse || region.ellipse) && !lamp.sheared && !area_contains(lamp, lamp_u, lamp_v)) {
    return false;
  }
  const Vec3f to = lamp.axis_u * (lamp_u - region.receiver_u) +
                   lamp.axis_v * (lamp_v - region.receiver_v) - lamp.axis * region.height;
  s.distance = length(to);
  s.wi = normalize(to);
  s.p = lamp.center + lamp.axis_u * lamp_u + lamp.axis_v * lamp_v;
  const float cosine = -dot(s.wi, lamp.axis);
  s.factor = area_lamp_factor(lamp, s.wi);
  if (!(s.factor > 0.0f) || !(cosine > 0.0f)) {
    return false;
  }
  s.pdf = pdf > 0.0f
              ? pdf
              : bounded_density(s.distance * (s.distance / region_area(lamp, region)) / cosine);
  return s.pdf > 0.0f;
}

// Distance along the unit direction d to the lamp's shining side; negative: it is not met.
inline float intersect_area_lamp(const Lamp& lamp, Vec3f p, Vec3f d) {
  const float cosine = -dot(d, lamp.axis);
  const Vec3f offset = p - lamp.center;
  const float height = dot(offset, lamp.axis);
  if (!(cosine > 0.0f) || !(height > 0.0f)) {
    return -1.0f;
  }
  const float t = height / cosine;
  const Vec3f q = offset + d * t;
  return area_contains(lamp, dot(q, lamp.dual_u), dot(q, lamp.dual_v)) ? t : -1.0f;
}

}  // namespace vernier
