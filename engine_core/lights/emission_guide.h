// How paths that start at lights are shared out.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "math/distribution.h"
#include "math/frame.h"
#include "math/octahedral.h"
#include "math/vec.h"

namespace vernier {

// Directions in which a light's paths are worth starting, in cells of equal solid angle.
struct DirectionGuide {
  static constexpr int kResolution = 32;  // cells along each side of the octahedral square

  PiecewiseConstant2D map;
  float share = 0;  // the part of the directions that are drawn from the map, in (0, 1)

  static size_t cell(Vec3f d) {
    const Vec2f p = sphere_to_square_equal_area(d) * static_cast<float>(kResolution);
    return static_cast<size_t>(p.y) * kResolution + static_cast<size_t>(p.x);
  }
  Vec3f sample(Vec2f u) const {
    float pdf;
    return square_to_sphere_equal_area(map.sample(u, pdf));
  }
  float pdf(Vec3f d) const { return map.pdf(sphere_to_square_equal_area(d)) * kInvFourPi; }
};

// Places across the rays of a distant light, in the square about the guide's sphere, that are worth
// starting at: q in [-1,1]^2 is q times the sphere's radius along the axes of Frame(direction).
struct PlaceGuide {
  static constexpr int kResolution = 16;  // cells along each side

  PiecewiseConstant2D map;
  float share = 0;  // the part of the rays aimed at the sphere that are drawn from the map

  static bool contains(Vec2f q) { return std::max(std::abs(q.x), std::abs(q.y)) < 1.0f; }
  // Of a place that the square contains.
  static size_t cell(Vec2f q) {
    const auto index = [](float x) {
      const float at = (0.5f * x + 0.5f) * static_cast<float>(kResolution);
      return std::min(static_cast<size_t>(at), static_cast<size_t>(kResolution - 1));
    };
    return index(q.y) * kResolution + index(q.x);
  }
  Vec2f sample(Vec2f u) const {
    float pdf;
    const Vec2f p = map.sample(u, pdf);
    return {2.0f * p.x - 1.0f, 2.0f * p.y - 1.0f};
  }
  // Density over the square's q.
  float pdf(Vec2f q) const {
    return contains(q) ? 0.25f * map.pdf({0.5f * q.x + 0.5f, 0.5f * q.y + 0.5f}) : 0.0f;
  }
};

// Any guide gives the same picture; a good one starts paths where they matter.
struct EmissionGuide {
  AliasTable lights;  // which light a path starts at
  // A part `share` in (0, 1) of the rays of suns and the environment passes this sphere, uniformly
  // over its disk but for what follows a PlaceGuide. The others pass beyond, as far as `reach`,
  // evenly over the logarithm of their distance: nothing near the sphere is left in the dark
  // however large the scene is. Share 0: all pass the sphere of the whole scene uniformly. Render
  // space.
  Vec3f center;
  float radius = 0;
  float reach = 0;
  float share = 0;
  // Of lights at finite places: those that have one, each light's number in `directions_of`.
  std::vector<DirectionGuide> directions;
  std::vector<uint32_t> directions_of;  // by light; empty: none has one

  // The same of suns and the environment, where the share is not 0.
  std::vector<PlaceGuide> places;
  std::vector<uint32_t> places_of;

  const PlaceGuide* place(uint32_t light) const {
    return light < places_of.size() && places_of[light] != kNone ? &places[places_of[light]]
                                                                 : nullptr;
  }
  // Where, of the square of a PlaceGuide, the ray through p along `direction` passes.
  Vec2f place_of(Vec3f p, Vec3f direction) const {
    const Frame across(direction);
    const Vec3f from = p - center;
    return Vec2f{dot(across.s, from), dot(across.t, from)} * (1.0f / radius);
  }
  const DirectionGuide* direction(uint32_t light) const {
    return light < directions_of.size() && directions_of[light] != kNone
               ? &directions[directions_of[light]]
               : nullptr;
  }
  static constexpr uint32_t kNone = 0xffffffffu;
};

}  // namespace vernier
