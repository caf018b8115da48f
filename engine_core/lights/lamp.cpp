#include "lights/lamp.h"

#include <algorithm>
#include <cmath>

#include "math/frame.h"
#include "nodes/material.h"

namespace vernier {
namespace {

// A sphere or disk smaller than this is a point: its radiance and the density of sampling it would
// leave float32 at distances that scenes have.
constexpr float kSmallestRadius = 1e-11f;
// Beyond this, squares of distances would leave it.
constexpr float kLargestRadius = 1e18f;
// Half angle below which float32 directions do not resolve a cone; it is a single direction.
constexpr float kSmallestHalfAngle = 4.0f * kUnitRoundoff;

// 1 - cos(angle) with full relative precision.
float one_minus_cos(float angle) { return 2.0f * square(std::sin(0.5f * angle)); }

// Radiance or intensity from emission, where the factor may be too large for float32.
Color scaled(Color emission, double factor) {
  const auto f = [factor](float e) {
    return static_cast<float>(
        std::min(static_cast<double>(e) * factor, static_cast<double>(kLargestRadiance)));
  };
  return {f(emission.x), f(emission.y), f(emission.z)};
}

// Watts that leave a point or sphere of this (Cycles: blender's watts are spread over the sphere's
// surface as radiance, divided by pi; a point is as bright as a sphere of any radius).
void make_point(const LightDesc& desc, Lamp& lamp) {
  lamp.radius = desc.radius >= kSmallestRadius ? std::min(desc.radius, kLargestRadius) : 0.0f;
  lamp.delta = lamp.radius == 0.0f;
  lamp.soft = desc.soft_falloff;
  const double radius = static_cast<double>(lamp.radius);
  const double pi = 3.14159265358979323846;
  const double area = lamp.delta ? 4.0 : 4.0 * pi * radius * radius;
  const double factor = (desc.normalize ? 1.0 / area : 1.0) / pi;
  lamp.radiance = scaled(desc.emission, factor);
  const double cross_section = lamp.delta ? 1.0 : pi * radius * radius;
  lamp.power = average(scaled(desc.emission, factor * cross_section * 4.0 * pi));
  lamp.hittable = desc.use_mis && !lamp.delta;
}

// Fills in `to_local`; false where the transform has no inverse: then any space about the axis.
bool set_local_space(const Transform& transform, Lamp& lamp) {
  Transform linear = transform;
  linear.m[3] = linear.m[7] = linear.m[11] = 0.0f;
  const Transform local = inverse(linear);
  if (is_black(local.column(0)) && is_black(local.column(1)) && is_black(local.column(2))) {
    const Frame frame(is_black(lamp.axis) ? Vec3f{0, 0, -1} : lamp.axis);
    lamp.to_local = {frame.s, frame.t, frame.n};
    return false;
  }
  lamp.to_local = {Vec3f{local.m[0], local.m[1], local.m[2]},
                   Vec3f{local.m[4], local.m[5], local.m[6]},
                   Vec3f{-local.m[8], -local.m[9], -local.m[10]}};
  return true;
}

// The smallest cone about `w` that holds the elliptic cone w + t (cos a u + sin a v), as 1 - cos.
// Where the transform shears, it is a cone that surely holds it.
float spread_cone(Vec3f u, Vec3f v, Vec3f w, float tan_half) {
  const float length_w = length(w);
  const Vec3f axis = w / length_w;
  const float along_u = dot(u, axis);
  const float along_v = dot(v, axis);
  const Vec3f pu = u - axis * along_u;
  const Vec3f pv = v - axis * along_v;
  const float a = dot(pu, pu), b = dot(pu, pv), c = dot(pv, pv);
  const float across = tan_half * safe_sqrt(0.5f * (a + c) + std::hypot(0.5f * (a - c), b));
  const float along = length_w - tan_half * std::hypot(along_u, along_v);
  if (!(along > 0.0f)) {
    return 2.0f;
  }
  const float hypotenuse = std::hypot(across, along);
  return across * (across / hypotenuse) / (hypotenuse + along);
}

void make_spot(const LightDesc& desc, bool singular, Lamp& lamp,
               std::vector<std::string>& warnings) {
  make_point(desc, lamp);
  const float half = 0.5f * clamp(desc.spot_angle, 0.0f, kPi);
  lamp.one_minus_cos_cone = one_minus_cos(half);
  const float width = lamp.one_minus_cos_cone * desc.spot_blend;
  lamp.inverse_blend = width > 0.0f ? 1.0f / width : kInfinity;
  if (singular) {
    warnings.push_back("light \"" + desc.name +
                       "\": its scale is zero along an axis; its cone is drawn round");
    lamp.one_minus_cos_spread = lamp.one_minus_cos_cone;
  } else if (half < 0.5f * kPi) {
    lamp.one_minus_cos_spread = spread_cone(desc.transform.column(0), desc.transform.column(1),
                                            -desc.transform.column(2), std::tan(half));
  }
  // Average of the smooth step over the cone: (1 - blend / 2) of the cone's solid angle.
  lamp.power *= 0.5f * lamp.one_minus_cos_spread * (1.0f - 0.5f * saturate(desc.spot_blend));
}

void make_sun(const LightDesc& desc, Lamp& lamp) {
  const float half = 0.5f * desc.sun_angle;
  lamp.delta = half < kSmallestHalfAngle;
  lamp.one_minus_cos_sun = one_minus_cos(half);
  // Watts per square metre across the direction, as Cycles normalises them; without, radiance.
  const double sine = std::sin(static_cast<double>(half));
  const double disk = 3.14159265358979323846 * sine * sine;
  lamp.radiance = scaled(desc.emission, lamp.delta || !desc.normalize ? 1.0 : 1.0 / disk);
  lamp.power = average(scaled(desc.emission, lamp.delta || desc.normalize ? 1.0 : disk));
  lamp.hittable = desc.use_mis && !lamp.delta;
}

void make_area(const LightDesc& desc, Lamp& lamp, std::vector<std::string>& warnings) {
  const Vec3f u = desc.transform.column(0) * desc.size_x;
  const Vec3f v = desc.transform.column(1) * desc.size_y;
  lamp.axis_u = normalize(u);
  lamp.axis_v = normalize(v);
  lamp.half_u = 0.5f * length(u);
  lamp.half_v = 0.5f * length(v);
  const Vec3f across = cross(lamp.axis_u, lamp.axis_v);
  const Vec3f normal = normalize(across);
  lamp.ellipse = desc.shape == AreaShape::kEllipse;
  const float sides = 4.0f * lamp.half_u * lamp.half_v;
  const float fill = lamp.ellipse ? kPi / 4.0f : 1.0f;
  lamp.area = sides * length(across) * fill;
  if (!(lamp.area > 0.0f) || !(1.0f / lamp.area < kLargestDensity) || is_black(lamp.axis)) {
    // Cycles drops area lamps without an area too.
    lamp.radiance = {};
    lamp.power = 0.0f;
    return;
  }
  // The plane spanned by its sides; where a transform shears, -z is not quite its normal.
  lamp.axis = dot(normal, lamp.axis) < 0.0f ? -normal : normal;
  lamp.sheared = std::abs(dot(lamp.axis_u, lamp.axis_v)) > 1e-5f;
  lamp.dual_u = cross(lamp.axis_v, lamp.axis) / dot(cross(lamp.axis_v, lamp.axis), lamp.axis_u);
  lamp.dual_v = cross(lamp.axis_u, lamp.axis) / dot(cross(lamp.axis_u, lamp.axis), lamp.axis_v);

  const double pi = 3.14159265358979323846;
  const double factor =
      (desc.normalize ? 1.0 / (static_cast<double>(sides) * static_cast<double>(fill)) : 1.0) / pi;
  const float half_spread = 0.5f * clamp(desc.spread, 0.0f, kPi);
  lamp.delta = half_spread < kSmallestHalfAngle;
  lamp.spreads = desc.spread < kPi;
  if (lamp.spreads && !lamp.delta) {
    // The soft box's grid passes (tan a - tan x) / (tan a - a) of the light, a half the spread: its
    // integral over the hemisphere with the cosine is pi (Cycles, area.h and light.cpp). For small
    // angles tan a - a is a^3 / 3.
    lamp.tan_half_spread = std::tan(half_spread);
    lamp.normalize_spread = half_spread > 0.05f ? 1.0f / (lamp.tan_half_spread - half_spread)
                                                : 3.0f / (half_spread * half_spread * half_spread);
  }
  // Parallel rays: all of the watts go one way.
  lamp.radiance = scaled(desc.emission, lamp.delta ? factor * pi : factor);
  lamp.power = average(scaled(desc.emission, factor * pi * static_cast<double>(lamp.area)));
  lamp.hittable = desc.use_mis && !lamp.delta;
  if (lamp.sheared && lamp.spreads) {
    warnings.push_back("light \"" + desc.name + "\": its transform shears it; noise is higher");
  }
}

}  // namespace

Lamp make_lamp(const LightDesc& desc, const std::array<double, 3>& origin, const Material* shader,
               std::vector<std::string>& warnings) {
  Lamp lamp;
  lamp.kind = desc.kind;
  lamp.cast_shadow = desc.cast_shadow;
  lamp.visibility = desc.visibility;
  const Vec3f at = desc.transform.translation();
  lamp.center = {static_cast<float>(static_cast<double>(at.x) - origin[0]),
                 static_cast<float>(static_cast<double>(at.y) - origin[1]),
                 static_cast<float>(static_cast<double>(at.z) - origin[2])};
  lamp.axis = normalize(-desc.transform.column(2));
  if (is_black(lamp.axis) && desc.kind != LightKind::kPoint) {
    warnings.push_back("light \"" + desc.name + "\": its scale is zero; it is left out");
    return lamp;
  }
  const bool singular = !set_local_space(desc.transform, lamp);
  switch (desc.kind) {
    case LightKind::kPoint:
      make_point(desc, lamp);
      break;
    case LightKind::kSpot:
      make_spot(desc, singular, lamp, warnings);
      break;
    case LightKind::kSun:
      make_sun(desc, lamp);
      break;
    case LightKind::kArea:
      make_area(desc, lamp, warnings);
      break;
  }
  if (shader) {
    const MaterialTraits& traits = shader->traits();
    if (traits.emission_constant) {
      lamp.radiance *= traits.average_emission;
      lamp.radiance = bounded_radiance(lamp.radiance);
      lamp.power *= average(traits.average_emission);
    } else {
      lamp.shader = shader;
      // An estimate of zero does not make the lamp dark.
      const float estimate = average(abs(traits.average_emission));
      lamp.power *= estimate > 0.0f ? estimate : 1.0f;
    }
  }
  return lamp;
}

}  // namespace vernier
