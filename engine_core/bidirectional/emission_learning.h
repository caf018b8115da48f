// What pilots learn of where paths are worth starting at lights.
#pragma once

#include <cstdint>
#include <vector>

#include "lights/emission_guide.h"
#include "lights/light_sampler.h"
#include "scene/scene.h"

namespace vernier {

// Where a path from a light begins: in which cell of what guides that light, or none.
struct EmissionOrigin {
  uint32_t light = kNoIndex;
  bool guided = false;
  size_t cell = 0;

  EmissionOrigin() = default;
  EmissionOrigin(const EmissionGuide& guide, const EmissionSample& e) : light(e.light) {
    if (!e.infinite) {
      guided = !e.delta_direction;
      cell = DirectionGuide::cell(e.direction);
    } else if (guide.share > 0.0f) {
      const Vec2f q = guide.place_of(e.p, e.direction);
      guided = PlaceGuide::contains(q);
      cell = guided ? PlaceGuide::cell(q) : 0;
    }
  }
};

// Adds up what paths that start at each light are worth, in any unit.
struct EmissionTally {
  std::vector<double> by_light;
  // What paths that started at the light have found, by light and by cell.
  std::vector<std::vector<float>> by_cell;
  std::vector<double> from_light;

  explicit EmissionTally(uint32_t lights) : by_light(lights), by_cell(lights), from_light(lights) {}

  void add(const EmissionTally& other);
  // A path of `light` that started there was worth `amount`.
  void credit(const EmissionOrigin& origin, uint32_t light, double amount);
};

// Aims distant lights at a sphere about the points, but for the outermost. Reorders the points.
void aim_at(std::vector<Vec3f>& points, const Scene& scene, EmissionGuide& guide);
// Chooses lights by what the pilot saw them do. Never 0 where it was not, and 0 where it was.
void choose_by(const EmissionTally& tally, EmissionGuide& guide);
// Directs the lights that matter most to where their paths were of use.
void direct_by(const EmissionTally& tally, const LightSampler& lights, EmissionGuide& guide);

}  // namespace vernier
