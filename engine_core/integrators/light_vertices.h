// The ends of all light's sub-paths of a batch, to be merged with the camera's.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "integrators/bidirectional_plan.h"
#include "integrators/technique_set.h"
#include "paths/mis.h"
#include "spatial/hash_grid.h"

namespace vernier {

// A vertex of a light's sub-path, as merging needs it: 52 bytes, and with its position and place
// in the grid 88 at most.
struct LightVertex {
  Vec3f ng;                // unit geometric normal, on the side of wi
  Vec3f wi;                // unit, back along the path: where light comes from
  Color beta;              // of the path up to here, before scattering
  float neighbour, chain;  // MergeRatios
  uint16_t bounces;        // before the vertex

  MergeRatios ratios() const {
    return {static_cast<double>(neighbour), static_cast<double>(chain)};
  }
};

// One path from the lights for each pixel, and where they end on surfaces. It is made in stages:
// the paths, the places of their vertices in the order of the paths, the grid.
class LightVertices : public LightPass {
 public:
  LightVertices(const RenderContext& context, const Batch& batch);

  int stages() const override;
  size_t jobs(int stage) const override;
  void run(int stage, size_t job, const RenderContext& context, RenderStats& stats) override;

  // Within which vertices are gathered, metres; 0: nothing is.
  float radius() const { return radius_; }
  // The number of paths times the area of the disk of that radius, m^2.
  double area() const { return area_; }
  size_t size() const { return vertices_.size(); }

  // Calls visit(vertex, position, distance_squared) for all within the radius of p.
  template <class Visit>
  void for_each(Vec3f p, const Visit& visit) const {
    grid_.for_each(p, [&](uint32_t i, float distance_squared) {
      visit(vertices_[i], positions_[i], distance_squared);
    });
  }

 private:
  struct Part {
    std::vector<Vec3f> positions;
    std::vector<LightVertex> vertices;
    size_t first = 0;
  };
  enum Stage : int { kTrace, kLayOut, kGather, kGrid };

  void trace(Part& part, size_t first, size_t last, const RenderContext& context,
             RenderStats& stats) const;

  const Batch batch_;
  const TechniqueSet techniques_;
  int width_, left_, bottom_;  // of the film's part that is rendered
  size_t paths_;
  float radius_ = 0;
  double area_ = 0;
  std::vector<Part> parts_;
  std::vector<Vec3f> positions_;
  std::vector<LightVertex> vertices_;
  HashGrid grid_;
  std::optional<HashGridBuild> grid_build_;
};

std::unique_ptr<LightPass> make_light_vertices(const RenderContext& context, const Batch& batch);

}  // namespace vernier
