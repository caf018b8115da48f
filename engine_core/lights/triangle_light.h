// Emissive triangles, which shine from both sides.
//
// A triangle that is large for its distance is sampled uniformly in its solid angle (Arvo 1995,
// "Stratified Sampling of Spherical Triangles"), a distant one by its area. Which of the two
// depends on the receiver's position alone.
#pragma once

#include "lights/lamp.h"
#include "lights/light_sample.h"
#include "math/warp.h"

namespace vernier {

// Above this solid angle (of at most 2 pi) the receiver nearly lies in the triangle and the angles
// of the spherical triangle are lost to rounding.
inline constexpr float kLargestSphericalTriangle = 6.2f;

// One cache line: scenes may have more lights than caches hold.
struct alignas(64) TriangleLight {
  Vec3f v0, e1, e2;  // a corner and the edges from it, render space
  Vec3f n;           // unit, e1 x e2
  float area = 0;    // m^2
  uint32_t instance = 0, triangle = 0;
  uint32_t emitter = 0;  // LightTable::emitters
};

// What many emissive triangles have in common.
struct TriangleEmitter {
  const Material* material = nullptr;
  uint32_t visibility = 0;  // Visibility bits
  bool constant = false;    // alike everywhere and in all directions...
  Color radiance;           // ...namely this
};

// Length of a vector that may be too short or long for its square.
inline float safe_length(Vec3f v) {
  const float squared = length_squared(v);
  if (squared > 1e-30f && squared < 1e30f) {
    return std::sqrt(squared);
  }
  const float scale = max_component(abs(v));
  return scale > 0.0f ? scale * length(v / splat(scale)) : 0.0f;
}

// Sets the normal and the area from the edges.
inline void measure(TriangleLight& light) {
  const Vec3f c = cross(light.e1, light.e2);
  light.n = normalize(c);
  light.area = 0.5f * safe_length(c);
}

// The spherical triangle that a receiver sees.
struct SphericalTriangle {
  Vec3f a, b, c;  // unit, to the corners
  float solid_angle = 0;
};

// True where the triangle is sampled by solid angle from p.
inline bool view_triangle(const TriangleLight& light, Vec3f p, SphericalTriangle& view) {
  const Vec3f a = light.v0 - p;
  const Vec3f b = a + light.e1;
  const Vec3f c = a + light.e2;
  const float size2 = std::max(length_squared(light.e1), length_squared(light.e2));
  // Closer than some one and a half edges; farther away the density of area sampling varies little
  // and the spherical triangle costs more than it saves.
  if (!(length_squared(a + b + c) < 20.0f * size2)) {
    return false;
  }
  const float la = length(a), lb = length(b), lc = length(c);
  if (!(std::min(la, std::min(lb, lc)) > 0.0f)) {
    return false;
  }
  view.a = a / la;
  view.b = b / lb;
  view.c = c / lc;
  // Van Oosterom and Strackee 1983. The triple product from the edges, which do not cancel.
  const float triple = std::abs(dot(view.a, cross(light.e1 / lb, light.e2 / lc)));
  view.solid_angle = 2.0f * std::atan2(triple, 1.0f + dot(view.a, view.b) + dot(view.a, view.c) +
                                                   dot(view.b, view.c));
  return view.solid_angle >= kSmallestSphericalSample &&
         view.solid_angle <= kLargestSphericalTriangle;
}

// The unit vector at an angle from the unit vector a toward another, given 1 - cos of the angle.
inline Vec3f rotate_toward(Vec3f a, Vec3f toward, float one_minus_cos) {
  const Vec3f across = normalize(toward - a * dot(toward, a));
  return normalize(a * (1.0f - one_minus_cos) +
                   across * safe_sqrt(one_minus_cos * (2.0f - one_minus_cos)));
}

inline Vec3f sample_spherical_triangle(const TriangleLight& light, SphericalTriangle view,
                                       Vec2f u) {
  // Normals of the planes of the sides, from the edges: the directions to two near corners differ
  // by little more than their rounding.
  Vec3f n_ab = normalize(cross(view.a, light.e1));
  Vec3f n_bc = normalize(cross(view.b, light.e2 - light.e1));
  Vec3f n_ca = normalize(cross(light.e2, view.a));
  // The construction divides by the sine of the angle at a: a is the corner nearest to a right one.
  Vec3f sines{length_squared(cross(n_ca, n_ab)), length_squared(cross(n_ab, n_bc)),
              length_squared(cross(n_bc, n_ca))};
  if (sines.y > sines.x && sines.y >= sines.z) {
    view = {view.b, view.c, view.a, view.solid_angle};
    n_ca = n_ab;
    n_ab = n_bc;
    sines.x = sines.y;
  } else if (sines.z > sines.x) {
    view = {view.c, view.a, view.b, view.solid_angle};
    n_ab = n_ca;
    n_ca = n_bc;
    sines.x = sines.z;
  }
  const float sin_alpha = std::min(std::sqrt(sines.x), 1.0f);
  const float alpha = std::atan2(sin_alpha, -dot(n_ab, n_ca));
  // The third corner of the triangle a, b, corner that holds the part u.x of the area, at cos q
  // from a (Arvo, figure 3). His s, t, u, v give, without their cancellation, with c the side ab,
  // 1 - q = w (1 + cos c) / (w + sin(alpha - part) sin(alpha) (1 - cos c)), w = 1 - cos(part).
  const float part = u.x * view.solid_angle;
  const float w = 2.0f * square(std::sin(0.5f * part));
  const float m = 0.5f * length_squared(view.a - view.b);
  const float whole = w + std::sin(alpha - part) * sin_alpha * m;
  const float one_minus_q = whole > 0.0f ? std::min(w * (2.0f - m) / whole, 2.0f) : 0.0f;
  const Vec3f corner = rotate_toward(view.a, view.c, one_minus_q);
  return rotate_toward(view.b, corner, u.y * 0.5f * length_squared(corner - view.b));
}

struct TriangleSample {
  ShapeSample shape;
  float b1 = 0, b2 = 0;  // barycentric coordinates of the second and third corner
};

inline float pdf_triangle_area(const TriangleLight& light, float distance, float abs_cos) {
  return bounded_density(distance * (distance / light.area) /
                         std::max(abs_cos, std::numeric_limits<float>::min()));
}

inline float pdf_triangle_light(const TriangleLight& light, Vec3f p, float distance,
                                float abs_cos) {
  SphericalTriangle view;
  return view_triangle(light, p, view) ? 1.0f / view.solid_angle
                                       : pdf_triangle_area(light, distance, abs_cos);
}

inline bool sample_triangle_light(const TriangleLight& light, Vec3f p, Vec2f u,
                                  TriangleSample& out) {
  ShapeSample& s = out.shape;
  s.n = light.n;
  SphericalTriangle view;
  const bool spherical = view_triangle(light, p, view);
  const Vec3f to_corner = light.v0 - p;
  if (spherical) {
    s.wi = sample_spherical_triangle(light, view, u);
    // Where the direction meets the triangle (Moller and Trumbore 1997).
    const Vec3f h = cross(s.wi, light.e2);
    const float determinant = dot(light.e1, h);
    if (determinant == 0.0f) {
      return false;
    }
    const Vec3f g = cross(to_corner, light.e1);
    out.b1 = saturate(-dot(to_corner, h) / determinant);
    out.b2 = clamp(-dot(s.wi, g) / determinant, 0.0f, 1.0f - out.b1);
  } else {
    const Vec2f b = square_to_triangle(u);
    out.b1 = b.x;
    out.b2 = b.y;
  }
  const Vec3f to = to_corner + light.e1 * out.b1 + light.e2 * out.b2;
  s.distance = safe_length(to);
  s.p = light.v0 + light.e1 * out.b1 + light.e2 * out.b2;
  if (!spherical) {
    s.wi = normalize(to);
  }
  const float cosine = dot(s.n, s.wi);
  if (cosine > 0.0f) {
    s.n = -s.n;
  }
  s.factor = 1.0f;
  s.pdf =
      spherical ? 1.0f / view.solid_angle : pdf_triangle_area(light, s.distance, std::abs(cosine));
  return cosine != 0.0f && s.pdf > 0.0f;
}

}  // namespace vernier
