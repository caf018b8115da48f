// Which vertices of paths from lights are worth joining to which of paths from the camera.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "paths/space_cells.h"

namespace vernier {

// A number for every pair of a camera cell and a light cell.
class CellPairs {
 public:
  CellPairs() = default;
  CellPairs(uint32_t camera_cells, uint32_t light_cells, double value = 0.0)
      : light_cells_(light_cells), values_(size_t{camera_cells} * light_cells, value) {}

  double& operator()(uint32_t camera, uint32_t light) { return row(camera)[light]; }
  double operator()(uint32_t camera, uint32_t light) const { return row(camera)[light]; }
  double* row(uint32_t camera) { return values_.data() + size_t{camera} * light_cells_; }
  const double* row(uint32_t camera) const {
    return values_.data() + size_t{camera} * light_cells_;
  }
  void add(const CellPairs& other) {
    for (size_t i = 0; i < values_.size(); ++i) {
      values_[i] += other.values_[i];
    }
  }

 private:
  size_t light_cells_ = 0;
  std::vector<double> values_;
};

// Light paths can be shared by all samples of a batch: every camera vertex is then joined to a few
// of their vertices, chosen by what such joins were found to give (after Popov et al. 2015,
// "Probabilistic Connections for Bidirectional Path Tracing"). Where most light stays where no
// camera path ever comes, as behind a door that is ajar, nearly all other joins would be of no use.
// The choice is by the places of both ends alone, in cells, so that it can be told of any path: the
// weights need it. Without a guide, a sample's camera vertices are joined to each vertex of its own
// light path, once.
class JoinGuide {
 public:
  JoinGuide() = default;
  // Cells about the vertices of both ends. Every join is as useful as any other.
  JoinGuide(SpaceCells&& camera, SpaceCells&& light);

  const SpaceCells& camera_cells() const { return camera_; }
  const SpaceCells& light_cells() const { return light_; }
  // How useful joins of these cells are, within the camera cell; positive.
  const CellPairs& uses() const { return uses_; }

  // Takes what joins gave, relative to the pixels' own brightness, and how many there were, by
  // cells. `vertices`: of light paths, by light cell.
  void learn(const CellPairs& found, const CellPairs& tries, const std::vector<double>& vertices);
  // Joins every camera vertex to `joins` light vertices, of which a light path brings so many on
  // average, by cell. From here on paths are shared.
  void balance(uint32_t joins, const std::vector<double>& vertices);
  uint32_t count() const { return joins_; }
  bool shares() const { return joins_ > 0; }

  // How often a light vertex is joined to a camera vertex, for each light path on average: the
  // factor of such joins in technique densities. Render space.
  double joins(Vec3f light, Vec3f camera) const {
    return shares() ? factors_(camera_(camera), light_(light)) : 1.0;
  }

 private:
  SpaceCells camera_, light_;
  CellPairs uses_ = CellPairs(1, 1, 1.0), factors_ = CellPairs(1, 1, 1.0);
  uint32_t joins_ = 0;
};

}  // namespace vernier
