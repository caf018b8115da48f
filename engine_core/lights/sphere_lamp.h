// Point and spot lamps.
//
// Blender has two shapes of them: a sphere, and with "soft falloff" a disk that always faces the
// receiver. Seen from outside, either fills a round cone about the direction to its centre, and
// both are sampled uniformly in the solid angle of that cone. A spot is sampled in the cone that
// it lights instead, where that is narrower.
#pragma once

#include "lights/lamp.h"
#include "lights/light_sample.h"
#include "math/frame.h"
#include "math/warp.h"

namespace vernier {

// The part of a spot's radiance that goes along `d` (unit, away from the lamp): Blender's smooth
// step in the cosine, in the lamp's own space.
inline float spot_attenuation(const Lamp& lamp, Vec3f d) {
  const Vec3f local = normalize(
      Vec3f{dot(lamp.to_local[0], d), dot(lamp.to_local[1], d), dot(lamp.to_local[2], d)});
  if (!(local.z > -1.0f)) {
    return 0.0f;
  }
  // cos(angle) - cos(half angle of the cone), from 1 - cos: it keeps its digits in narrow cones.
  const float one_minus_cos =
      local.z > 0.0f ? (local.x * local.x + local.y * local.y) / (1.0f + local.z) : 1.0f - local.z;
  const float inside = lamp.one_minus_cos_cone - one_minus_cos;
  if (!(inside > 0.0f)) {
    return 0.0f;
  }
  const float x = std::min(inside * lamp.inverse_blend, 1.0f);
  return x * x * (3.0f - 2.0f * x);
}

// How a receiver sees a sphere or a disk that faces it.
struct SphereView {
  Vec3f to_center;          // unit
  float distance = 0;       // to the centre
  float one_minus_cos = 0;  // of the half angle that it fills
  bool inside = false;      // the receiver is in the sphere
};

inline SphereView view_sphere(const Lamp& lamp, Vec3f p) {
  SphereView view;
  const Vec3f d = lamp.center - p;
  const float d2 = length_squared(d);
  const float r2 = square(lamp.radius);
  view.distance = std::sqrt(d2);
  view.to_center = normalize(d);
  if (lamp.soft) {
    const float hypotenuse = std::sqrt(d2 + r2);
    view.one_minus_cos = r2 / (hypotenuse * (hypotenuse + view.distance));
  } else if (d2 > r2) {
    const float sin2 = r2 / d2;
    view.one_minus_cos = sin2 / (1.0f + std::sqrt(1.0f - sin2));
  } else {
    view.inside = true;
  }
  return view;
}

// Distance along the unit direction d to the light of this lamp; negative: it is not met.
inline float intersect_sphere(const Lamp& lamp, const SphereView& view, Vec3f p, Vec3f d) {
  const Vec3f to = lamp.center - p;
  const float along = dot(to, d);
  const float r2 = square(lamp.radius);
  const float perpendicular2 = length_squared(to - d * along);
  if (lamp.soft) {
    if (!(along > 0.0f) || !(perpendicular2 < square(lamp.radius * (along / view.distance)))) {
      return -1.0f;
    }
    return view.distance * (view.distance / along);
  }
  if (view.inside) {
    return along + safe_sqrt(r2 - perpendicular2);
  }
  return along > 0.0f && perpendicular2 <= r2 ? along - std::sqrt(r2 - perpendicular2) : -1.0f;
}

// Whether a spot is sampled in the cone that it lights rather than in the one that it fills.
inline bool samples_spread(const Lamp& lamp, const SphereView& view) {
  return lamp.kind == LightKind::kSpot && lamp.one_minus_cos_spread < view.one_minus_cos;
}

inline float pdf_sphere_lamp(const Lamp& lamp, const Receiver& from, const SphereView& view,
                             Vec3f wi) {
  if (view.inside) {
    return from.transmits ? kInvFourPi : cosine_hemisphere_pdf(dot(wi, from.ns));
  }
  return bounded_density(uniform_cone_pdf(samples_spread(lamp, view) ? lamp.one_minus_cos_spread
                                                                     : view.one_minus_cos));
}

// Of the lamp's radiance, what it sends along -wi to a receiver that sees it so.
inline float sphere_lamp_factor(const Lamp& lamp, const SphereView& view, Vec3f wi) {
  // In its own sphere a spot shines everywhere, as in Cycles.
  return lamp.kind == LightKind::kSpot && !view.inside ? spot_attenuation(lamp, -wi) : 1.0f;
}

inline bool sample_sphere_lamp(const Lamp& lamp, const Receiver& from, Vec2f u, ShapeSample& s) {
  const SphereView view = view_sphere(lamp, from.p);
  if (lamp.delta) {
    if (!(view.distance > 0.0f)) {
      return false;
    }
    s.wi = view.to_center;
    s.distance = view.distance;
    s.p = lamp.center;
    s.n = -s.wi;
    s.pdf = 1.0f;
    // Two divisions: the square of a distance may leave float32 where neither quotient does.
    s.factor = sphere_lamp_factor(lamp, view, s.wi) / view.distance / view.distance;
    return s.factor > 0.0f;
  }
  if (view.inside) {
    s.wi = from.transmits ? square_to_uniform_sphere(u)
                          : Frame(from.ns).to_world(square_to_cosine_hemisphere(u));
  } else {
    if (!(view.distance > 0.0f)) {
      return false;
    }
    const bool spread = samples_spread(lamp, view);
    const Frame frame(spread ? -lamp.axis : view.to_center);
    s.wi = normalize(frame.to_world(
        square_to_uniform_cone(u, spread ? lamp.one_minus_cos_spread : view.one_minus_cos)));
    if (spread && intersect_sphere(lamp, view, from.p, s.wi) < 0.0f) {
      return false;
    }
  }
  s.factor = sphere_lamp_factor(lamp, view, s.wi);
  s.pdf = pdf_sphere_lamp(lamp, from, view, s.wi);
  if (!(s.factor > 0.0f) || !(s.pdf > 0.0f)) {
    return false;
  }
  // A direction on the rim may miss by rounding: the rim is where it meets the lamp.
  s.distance = intersect_sphere(lamp, view, from.p, s.wi);
  if (s.distance < 0.0f) {
    s.distance = dot(lamp.center - from.p, s.wi);
  }
  s.p = from.p + s.wi * s.distance;
  if (lamp.soft) {
    s.n = -view.to_center;
  } else {
    const Vec3f outward = normalize(s.p - lamp.center);
    s.p = lamp.center + outward * lamp.radius;
    s.n = view.inside ? -outward : outward;
  }
  return true;
}

}  // namespace vernier
