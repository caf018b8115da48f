// Suns: a disk of the sky of uniform radiance, or a single direction.
#pragma once

#include <cmath>

#include "lights/lamp.h"
#include "lights/light_sample.h"
#include "math/frame.h"
#include "math/warp.h"

namespace vernier {

inline bool sun_contains(const Lamp& lamp, Vec3f wi) {
  // |a - b|^2 = 2 (1 - cos) for unit vectors: as exact as the directions themselves, so that the
  // rim lies where sampling has it, to their rounding.
  return !lamp.delta && 0.5f * length_squared(wi + lamp.axis) <= lamp.one_minus_cos_sun;
}

// Whether sampling may have drawn the direction: those at the rim of a small disk are rounded
// beyond it. Its roundings are those of a frame's axes, of three products and of a length.
inline bool sun_may_draw(const Lamp& lamp, Vec3f wi) {
  const float chord = std::sqrt(2.0f * lamp.one_minus_cos_sun) + gamma(8);
  return !lamp.delta && length_squared(wi + lamp.axis) <= square(chord);
}

inline float pdf_sun(const Lamp& lamp) {
  return bounded_density(uniform_cone_pdf(lamp.one_minus_cos_sun));
}

inline bool sample_sun(const Lamp& lamp, Vec2f u, ShapeSample& s) {
  s.wi = lamp.delta
             ? -lamp.axis
             : normalize(
                   Frame(-lamp.axis).to_world(square_to_uniform_cone(u, lamp.one_minus_cos_sun)));
  s.distance = kInfinity;
  s.n = -s.wi;
  s.pdf = lamp.delta ? 1.0f : pdf_sun(lamp);
  s.factor = 1.0f;
  return true;
}

}  // namespace vernier
