#include "bidirectional/emission_learning.h"

#include <algorithm>
#include <cmath>

namespace vernier {
namespace {

// The part of the choice of lights that goes by their power all the same: a pilot has not seen all.
constexpr double kByPower = 0.25;
// The part of distant lights' rays that is aimed.
constexpr float kAimed = 0.75f;
// Of the points that the camera's paths visit, those that the aim covers.
constexpr double kCovered = 0.95;

// Lights that get a guide to their directions: no more than these, and each with at least this part
// of the light that paths from lights carry.
constexpr size_t kMostGuided = 16;
constexpr double kLeastGuided = 0.01;
// The part of their directions that follow it.
constexpr float kGuided = 0.75f;

using Cells = std::vector<float>;
constexpr size_t kMostCells = DirectionGuide::kResolution * DirectionGuide::kResolution;
static_assert(PlaceGuide::kResolution <= DirectionGuide::kResolution);

// Each cell's value shared with its eight neighbours: what one path found tells of those beside it.
PiecewiseConstant2D blurred(const Cells& cells, int n) {
  Cells result(static_cast<size_t>(n * n));
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      const float value = cells[static_cast<size_t>(y * n + x)] / 9.0f;
      for (int dy = -1; dy <= 1 && value > 0.0f; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const int to_x = std::clamp(x + dx, 0, n - 1), to_y = std::clamp(y + dy, 0, n - 1);
          result[static_cast<size_t>(to_y * n + to_x)] += value;
        }
      }
    }
  }
  return PiecewiseConstant2D(result, n, n);
}

}  // namespace

void EmissionTally::add(const EmissionTally& other) {
  for (size_t light = 0; light < by_light.size(); ++light) {
    by_light[light] += other.by_light[light];
    from_light[light] += other.from_light[light];
    const Cells& cells = other.by_cell[light];
    by_cell[light].resize(std::max(by_cell[light].size(), cells.size()));
    for (size_t i = 0; i < cells.size(); ++i) {
      by_cell[light][i] += cells[i];
    }
  }
}

void EmissionTally::credit(const EmissionOrigin& origin, uint32_t light, double amount) {
  if (!origin.guided) {
    return;
  }
  by_cell[light].resize(kMostCells);
  by_cell[light][origin.cell] += static_cast<float>(amount);
  from_light[light] += amount;
}

void aim_at(std::vector<Vec3f>& points, const Scene& scene, EmissionGuide& guide) {
  if (points.empty()) {
    return;
  }
  for (int axis = 0; axis < 3; ++axis) {
    const auto middle = points.begin() + static_cast<ptrdiff_t>(points.size() / 2);
    std::nth_element(points.begin(), middle, points.end(),
                     [&](const Vec3f& a, const Vec3f& b) { return a[axis] < b[axis]; });
    guide.center[axis] = (*middle)[axis];
  }
  const auto last =
      points.begin() + static_cast<ptrdiff_t>(kCovered * static_cast<double>(points.size() - 1));
  std::nth_element(points.begin(), last, points.end(), [&](const Vec3f& a, const Vec3f& b) {
    return length_squared(a - guide.center) < length_squared(b - guide.center);
  });
  guide.radius = length(*last - guide.center);
  if (!(guide.radius > 0.0f && guide.radius < scene.radius)) {
    return;
  }
  guide.share = kAimed;
  guide.reach = scene.radius + length(guide.center - scene.center);
  // Of distant lights' power that part counts which passes the sphere: however large the scene is,
  // they must not take all paths from the lamps in it.
  const double part = square(static_cast<double>(guide.radius) / static_cast<double>(scene.radius));
  std::vector<double> weights(scene.lights->count());
  for (uint32_t light = 0; light < weights.size(); ++light) {
    weights[light] = static_cast<double>(guide.lights.probability(light)) *
                     (scene.lights->is_infinite(light) ? part : 1.0);
  }
  guide.lights = AliasTable(weights);
}

void choose_by(const EmissionTally& tally, EmissionGuide& guide) {
  double attributed = 0.0;
  for (const double amount : tally.by_light) {
    attributed += amount;
  }
  if (!(attributed > 0.0)) {
    return;
  }
  std::vector<double> weights(tally.by_light.size());
  for (uint32_t light = 0; light < weights.size(); ++light) {
    const auto by_power = static_cast<double>(guide.lights.probability(light));
    const double seen = tally.by_light[light] / attributed;
    weights[light] = by_power > 0.0 ? seen + kByPower * (by_power - seen) : 0.0;
  }
  guide.lights = AliasTable(weights);
}

void direct_by(const EmissionTally& tally, const LightSampler& lights, EmissionGuide& guide) {
  std::vector<uint32_t> order;
  double total = 0.0;
  for (uint32_t light = 0; light < tally.from_light.size(); ++light) {
    total += tally.from_light[light];
    order.push_back(light);
  }
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    return tally.from_light[a] > tally.from_light[b];
  });
  guide.directions_of.assign(order.size(), EmissionGuide::kNone);
  guide.places_of = guide.directions_of;
  for (const uint32_t light : order) {
    if (guide.directions.size() + guide.places.size() == kMostGuided ||
        !(tally.from_light[light] > kLeastGuided * total)) {
      break;
    }
    if (lights.is_infinite(light)) {
      guide.places_of[light] = static_cast<uint32_t>(guide.places.size());
      guide.places.push_back({blurred(tally.by_cell[light], PlaceGuide::kResolution), kGuided});
      continue;
    }
    guide.directions_of[light] = static_cast<uint32_t>(guide.directions.size());
    guide.directions.push_back(
        {blurred(tally.by_cell[light], DirectionGuide::kResolution), kGuided});
  }
}

}  // namespace vernier
