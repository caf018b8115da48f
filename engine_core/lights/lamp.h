// A lamp as it is rendered: Blender's description turned into radiance and geometry.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "math/vec.h"
#include "scene/description.h"

namespace vernier {

class Material;

// Bounds within which radiances and densities are kept, so that no product with a cosine or a
// selection probability leaves float32. Only lights far beyond what can be displayed reach them.
inline constexpr float kLargestRadiance = 1e34f;
inline constexpr float kLargestDensity = 1e34f;

// Solid angle from which rectangles and triangles are sampled by it. It is computed from angles of
// the order of 1 with an error of some 8 u; smaller ones are sampled by area.
inline constexpr float kSmallestSphericalSample = 1e-3f;

inline Color bounded_radiance(Color c) { return min(c, splat(kLargestRadiance)); }
inline float bounded_density(float pdf) { return std::min(pdf, kLargestDensity); }

// Where a direction from a receiver meets a light, and how dense sampling is there.
struct ShapeSample {
  Vec3f wi;
  float distance = 0;
  Vec3f p;           // on the light
  Vec3f n;           // unit normal of the light there, on the receiver's side
  float pdf = 0;     // solid angle; delta lights: 1
  float factor = 0;  // of the lamp's radiance that arrives; delta lights: of its intensity or
                     // irradiance
};

struct Lamp {
  LightKind kind = LightKind::kPoint;
  bool delta = false;  // a point, a direction, or parallel rays
  bool soft = false;   // point, spot: a disk that faces the receiver, not a sphere
  bool cast_shadow = true;
  bool hittable = false;  // rays that scatter may meet it (Blender's multiple importance)
  uint32_t visibility = kVisibleAll;
  Vec3f center;          // render space
  Vec3f axis{0, 0, -1};  // unit, the way it shines
  // Radiance. Delta: intensity of points and spots, irradiance of suns and parallel areas.
  Color radiance;
  const Material* shader = nullptr;  // null where its emission is constant, and then in `radiance`
  float power = 0;                   // watts, average of RGB; suns: irradiance

  float radius = 0;  // point, spot
  // Rows that take a direction to the lamp's own space, with +z the way it shines; a spot's cone is
  // round there.
  std::array<Vec3f, 3> to_local{Vec3f{1, 0, 0}, Vec3f{0, 1, 0}, Vec3f{0, 0, -1}};
  float one_minus_cos_cone = 2;    // spot: of the half angle, in its own space
  float one_minus_cos_spread = 2;  // spot: of a cone about `axis` that holds the lit one
  float inverse_blend = 0;         // spot: 1 over the width of the smooth step, in cosines; or inf

  Vec3f axis_u, axis_v;          // area: unit
  Vec3f dual_u, dual_v;          // area: dot with an offset in the plane gives metres along u, v
  float half_u = 0, half_v = 0;  // area: metres
  float area = 0;                // area: m^2
  bool ellipse = false, sheared = false;
  bool spreads = false;  // area: narrower than the whole hemisphere
  float tan_half_spread = 0, normalize_spread = 0;

  float one_minus_cos_sun = 0;  // sun: of half its angular diameter
};

// The rendered form of `desc`, with its centre relative to `origin`. `shader` may be null.
// Appends to `warnings` where the lamp cannot be rendered as described.
Lamp make_lamp(const LightDesc& desc, const std::array<double, 3>& origin, const Material* shader,
               std::vector<std::string>& warnings);

}  // namespace vernier
