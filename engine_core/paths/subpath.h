// The vertices of one end of a path.
#pragma once

#include <cstdint>
#include <vector>

#include "paths/path_vertex.h"

namespace vernier {

// Vertices in the order in which a walk met them, each knowing its parent. Where a walk passed
// straight through a surface that also scatters, the vertex is a leaf: a path may end there, while
// those that follow have its parent for theirs. The memory is kept for the next path.
class Subpath {
 public:
  Subpath() : vertices_(kUsual) {}

  void clear() { count_ = 0, parent_ = kNoIndex; }
  uint32_t size() const { return count_; }
  const PathVertex* data() const { return vertices_.data(); }
  const PathVertex& operator[](uint32_t i) const { return vertices_[i]; }

  // A vertex to be filled. It is part of the path; drop() takes it back.
  PathVertex& append() {
    if (count_ == vertices_.size()) {
      vertices_.resize(2 * vertices_.size());
    }
    PathVertex& v = vertices_[count_++];
    v.parent = parent_;
    return v;
  }
  void drop() { --count_; }
  // The walk scatters at the last vertex: it is the parent of the next. Returns its number.
  uint32_t scatter() { return parent_ = count_ - 1; }

 private:
  static constexpr size_t kUsual = 16;

  std::vector<PathVertex> vertices_;
  uint32_t count_ = 0;
  uint32_t parent_ = kNoIndex;
};

}  // namespace vernier
