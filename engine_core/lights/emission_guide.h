// How paths that start at lights are shared out.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "math/distribution.h"
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

// Any guide gives the same picture; a good one starts paths where they matter.
struct EmissionGuide {
  AliasTable lights;  // which light a path starts at
  // A part `share` in (0, 1) of the rays of suns and the environment passes this sphere, uniformly
  // over its disk. The others pass beyond, as far as `reach`, evenly over the logarithm of their
  // distance: nothing near the sphere is left in the dark however large the scene is. Share 0: all
  // pass the sphere of the whole scene uniformly. Render space.
  Vec3f center;
  float radius = 0;
  float reach = 0;
  float share = 0;
  // Of lights at finite places: those that have one, each light's number in `directions_of`.
  std::vector<DirectionGuide> directions;
  std::vector<uint32_t> directions_of;  // by light; empty: none has one

  const DirectionGuide* direction(uint32_t light) const {
    return light < directions_of.size() && directions_of[light] != kNone
               ? &directions[directions_of[light]]
               : nullptr;
  }
  static constexpr uint32_t kNone = 0xffffffffu;
};

}  // namespace vernier
