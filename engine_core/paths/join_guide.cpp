#include "paths/join_guide.h"

#include <cmath>
#include <utility>

namespace vernier {
namespace {

// The part of the choice that is made evenly all the same: what was found is not all there is.
constexpr double kEvenly = 0.1;
// Pairs of cells were tried a few times only. So many tries count as having gone as all camera
// cells' did on average.
constexpr double kTriesAtFirst = 4.0;

}  // namespace

JoinGuide::JoinGuide(SpaceCells&& camera, SpaceCells&& light)
    : camera_(std::move(camera)),
      light_(std::move(light)),
      uses_(camera_.count(), light_.count(), 1.0),
      factors_(camera_.count(), light_.count(), 1.0) {}

void JoinGuide::learn(const CellPairs& found, const CellPairs& tries,
                      const std::vector<double>& vertices) {
  const uint32_t lights = light_.count();
  std::vector<double> use_of_all(lights);  // by light cell, over all camera cells
  double all_vertices = 0.0;
  for (uint32_t y = 0; y < lights; ++y) {
    double sum = 0.0, count = 0.0;
    for (uint32_t z = 0; z < camera_.count(); ++z) {
      sum += found(z, y);
      count += tries(z, y);
    }
    use_of_all[y] = count > 0.0 ? sum / count : 0.0;
    all_vertices += vertices[y];
  }
  for (uint32_t z = 0; z < camera_.count(); ++z) {
    double sum = 0.0, expected = 0.0;
    for (uint32_t y = 0; y < lights; ++y) {
      sum += found(z, y);
      expected += tries(z, y) * use_of_all[y];
    }
    const double level = expected > 0.0 ? sum / expected : 0.0;
    double* uses = uses_.row(z);
    double mean = 0.0;
    for (uint32_t y = 0; y < lights; ++y) {
      uses[y] =
          (found(z, y) + kTriesAtFirst * level * use_of_all[y]) / (tries(z, y) + kTriesAtFirst);
      mean += uses[y] * vertices[y] / all_vertices;
    }
    const bool known = mean > 0.0 && std::isfinite(mean);
    for (uint32_t y = 0; y < lights; ++y) {
      uses[y] = known ? kEvenly + (1.0 - kEvenly) * uses[y] / mean : 1.0;
    }
  }
}

void JoinGuide::balance(uint32_t joins, const std::vector<double>& vertices) {
  joins_ = joins;
  for (uint32_t z = 0; z < camera_.count(); ++z) {
    double sum = 0.0;
    for (uint32_t y = 0; y < light_.count(); ++y) {
      sum += uses_(z, y) * vertices[y];
    }
    for (uint32_t y = 0; y < light_.count(); ++y) {
      factors_(z, y) = sum > 0.0 ? joins * uses_(z, y) / sum : 1.0;
    }
  }
}

}  // namespace vernier
