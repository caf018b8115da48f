// Cells of space about points, as many in each.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "math/vec.h"

namespace vernier {

// Halves the points along the longest side of their box, and each half likewise: cells are small
// where points are dense, at any scale.
class SpaceCells {
 public:
  SpaceCells() = default;
  // 2^log2_cells of them. Without points: one.
  SpaceCells(std::vector<Vec3f>&& points, int log2_cells);

  uint32_t count() const { return static_cast<uint32_t>(splits_.size()); }
  // The number of the cell that p is in.
  uint32_t operator()(Vec3f p) const {
    uint32_t node = 1;
    while (node < count()) {
      node = 2 * node + (p[splits_[node].axis] < splits_[node].at ? 0 : 1);
    }
    return node - count();
  }

 private:
  // A binary tree in breadth-first order from 1; its leaves are the cells.
  struct Split {
    float at = 0;
    int axis = 0;
  };
  void split(Vec3f* first, Vec3f* last, uint32_t node);

  std::vector<Split> splits_ = std::vector<Split>(1);
};

}  // namespace vernier
