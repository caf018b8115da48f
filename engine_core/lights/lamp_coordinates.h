// The parametric coordinates that a lamp's shader reads.
#pragma once

#include "lights/lamp.h"
#include "math/vec.h"

namespace vernier {

// (u, v) of SurfacePoint at the lamp: barycentric, as Cycles fills them in for lamps, so that the
// texture coordinate (1 - u - v, u) covers the unit square over an area lamp, over a sun's disk,
// over the square about a spot's cone, or over longitude and latitude of a point.
inline Vec2f lamp_coordinates(const Lamp& lamp, const ShapeSample& shape) {
  const auto to_local = [&lamp](Vec3f d) {
    return Vec3f{dot(lamp.to_local[0], d), dot(lamp.to_local[1], d), dot(lamp.to_local[2], d)};
  };
  Vec2f texture{0.5f, 0.5f};
  switch (lamp.kind) {
    case LightKind::kArea: {
      const Vec3f q = shape.p - lamp.center;
      texture.x += clamp(dot(q, lamp.dual_u) / (2.0f * lamp.half_u), -0.5f, 0.5f);
      texture.y += clamp(dot(q, lamp.dual_v) / (2.0f * lamp.half_v), -0.5f, 0.5f);
      break;
    }
    case LightKind::kSpot: {
      const Vec3f local = normalize(to_local(-shape.wi));
      const float sine = safe_sqrt(lamp.one_minus_cos_cone * (2.0f - lamp.one_minus_cos_cone));
      // Not for directions beside the cone, where the plane of the square may be parallel to them.
      if (local.z > 0.0f && sine > 0.0f) {
        const float factor = 0.5f * (1.0f - lamp.one_minus_cos_cone) / (sine * local.z);
        texture = texture + Vec2f{local.x, local.y} * factor;
      }
      break;
    }
    case LightKind::kSun: {
      const float height = 1.0f - dot(shape.wi, lamp.axis);
      if (lamp.one_minus_cos_sun > 0.0f && height > 0.0f) {
        const float factor = 0.5f / std::sqrt(lamp.one_minus_cos_sun * height);
        texture = texture +
                  Vec2f{dot(lamp.to_local[0], shape.wi), dot(lamp.to_local[1], shape.wi)} * factor;
      }
      break;
    }
    case LightKind::kPoint: {
      const Vec3f local = normalize(to_local(shape.n));
      texture.x = local.x == 0.0f && local.y == 0.0f
                      ? 0.0f
                      : 0.5f - std::atan2(local.x, local.y) * kInvTwoPi;
      texture.y = 1.0f - std::acos(clamp(-local.z, -1.0f, 1.0f)) * kInvPi;
      break;
    }
  }
  return {texture.y, 1.0f - texture.x - texture.y};
}

}  // namespace vernier
