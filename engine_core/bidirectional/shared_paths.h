// The light vertices that all samples of a batch share.
#pragma once

#include <cstdint>
#include <vector>

#include "bidirectional/join_end.h"
#include "integrators/integrator.h"
#include "math/distribution.h"
#include "paths/join_guide.h"
#include "paths/path_vertex.h"

namespace vernier {

// Paths from lights, traced anew for every batch, and the choice of their vertices by use. Every
// sample has its own light path besides, which splats.
class SharedPaths : public LightPass {
 public:
  // `paths` of them, no more than a bound; `guide` chooses, and has been balanced.
  SharedPaths(const JoinGuide& guide, uint32_t paths, uint64_t seed);

  int stages() const override { return 2; }
  size_t jobs(int stage) const override { return stage == 0 ? groups_.size() : 1; }
  void run(int stage, size_t job, const RenderContext& context, RenderStats& stats) override;

  struct Choice {
    const PathVertex* vertex;
    const PathVertex* path;  // `vertex` and its parents are numbered from here
    uint32_t light;          // at which the path starts
    // How often it is chosen by one camera vertex, for each path of the batch.
    double joins;
  };
  // Where the vertices are that can be joined.
  std::vector<Vec3f> positions() const;
  uint32_t count() const { return paths_; }
  // Whether a camera vertex at p finds nothing to be joined to.
  bool empty(Vec3f p) const { return choices_[guide_.camera_cells()(p)].size() == 0; }
  // A vertex for the camera vertex at p, where not empty; u in [0,1)^2. `end`: the vertex in short.
  Choice choose(Vec3f p, Vec2f u, const JoinEnd*& end) const;

 private:
  struct Group {
    std::vector<PathVertex> vertices;
    std::vector<uint32_t> lights;  // by vertex
    std::vector<uint32_t> cells;   // by vertex; kNoIndex: cannot be joined
  };
  struct Place {
    JoinEnd end;  // its number is that in the group
    uint32_t group, light;
  };
  void trace(size_t job, const RenderContext& context, RenderStats& stats);
  void sort();

  const JoinGuide& guide_;
  uint32_t paths_;
  uint64_t seed_;
  std::vector<Group> groups_;
  std::vector<Place> places_;        // of what can be joined, by cell
  std::vector<uint32_t> first_;      // each cell's first among them, and their number
  std::vector<AliasTable> choices_;  // of a cell, by camera cell
};

// Those of a batch; null where the plan shares none.
std::unique_ptr<LightPass> make_shared_paths(const RenderContext& context, const Batch& batch);

}  // namespace vernier
