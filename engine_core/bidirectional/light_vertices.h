// The ends of all light's sub-paths of a batch, to be merged with the camera's.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "bidirectional/plan.h"
#include "bidirectional/technique_set.h"
#include "paths/mis.h"
#include "sampling/sobol.h"
#include "spatial/hash_grid.h"

namespace vernier {

// A vertex of a light's sub-path, as merging needs it: 60 bytes, and with its position and place
// in the grid 96 at most.
struct LightVertex {
  Vec3f ng;                // unit geometric normal, on the side of wi
  Vec3f wi;                // unit, back along the path: where light comes from
  Color beta;              // of the path up to here, before scattering
  float neighbour, chain;  // MergeRatios
  uint32_t path;           // the number of the path
  PathDepth depth;         // before the vertex

  MergeRatios ratios() const {
    return {static_cast<double>(neighbour), static_cast<double>(chain)};
  }
};

// Paths from the lights, and where they end on surfaces. It is made in stages:
// the paths, the places of their vertices in the order of the paths, the grid.
class LightVertices : public LightPass {
 public:
  // One path for each pixel of a batch.
  LightVertices(const RenderContext& context, const Batch& batch);
  // Paths `first` to `first + count` of a sequence of 2^log2_capacity that belongs to no pixel.
  LightVertices(const TechniqueSet& techniques, uint64_t seed, int log2_capacity, uint32_t first,
                size_t count, float radius)
      : LightVertices(techniques, {}, seed, log2_capacity, first, count, radius) {}

  int stages() const override;
  size_t jobs(int stage) const override;
  void run(int stage, size_t job, const RenderContext& context, RenderStats& stats) override;

  // Within which vertices are gathered, metres; 0: nothing is.
  float radius() const { return radius_; }
  // The number of paths times the area of the disk of that radius, m^2.
  double area() const { return area_; }
  size_t size() const { return vertices_.size(); }
  // The numbers that path `i` is made of.
  SobolSampler sampler(size_t i) const;

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
  using Crop = std::array<int32_t, 4>;

  LightVertices(const TechniqueSet& techniques, const Crop& crop, uint64_t seed, int log2_capacity,
                uint32_t first, size_t count, float radius);

  void trace(Part& part, size_t first, size_t last, const RenderContext& context,
             RenderStats& stats) const;

  const TechniqueSet techniques_;
  const Crop crop_;  // of the film; empty: the paths belong to no pixels
  const uint64_t seed_;
  const int log2_capacity_;
  const uint32_t first_;
  const size_t paths_;
  const float radius_;
  const double area_;
  std::vector<Part> parts_;
  std::vector<Vec3f> positions_;
  std::vector<LightVertex> vertices_;
  HashGrid grid_;
  std::optional<HashGridBuild> grid_build_;
};

// The radius of merges in a sample, metres: its square shrinks from that of the first sample with
// the number of the sample, from 1, to the power of alpha - 1 (Kaplanyan and Dachsbacher 2013,
// equation 20; memoryless as in Knaus and Zwicker 2011: no sample need know what others found).
// `footprint` as in BidirectionalPlan.
float merge_radius(const Settings& settings, float footprint, uint32_t sample);

std::unique_ptr<LightPass> make_light_vertices(const RenderContext& context, const Batch& batch);

}  // namespace vernier
