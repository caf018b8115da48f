#include "paths/space_cells.h"

#include <algorithm>

namespace vernier {
namespace {

int longest_side(const Vec3f* first, const Vec3f* last) {
  Vec3f low = *first, high = *first;
  for (const Vec3f* p = first; p != last; ++p) {
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], (*p)[axis]);
      high[axis] = std::max(high[axis], (*p)[axis]);
    }
  }
  const Vec3f size = high - low;
  return size.x >= size.y ? (size.x >= size.z ? 0 : 2) : (size.y >= size.z ? 1 : 2);
}

}  // namespace

SpaceCells::SpaceCells(std::vector<Vec3f>&& points, int log2_cells) {
  if (!points.empty()) {
    splits_.resize(size_t{1} << log2_cells);
    split(points.data(), points.data() + points.size(), 1);
  }
}

void SpaceCells::split(Vec3f* first, Vec3f* last, uint32_t node) {
  if (node >= count() || first == last) {
    return;
  }
  const int axis = longest_side(first, last);
  Vec3f* middle = first + (last - first) / 2;
  std::nth_element(first, middle, last,
                   [axis](const Vec3f& a, const Vec3f& b) { return a[axis] < b[axis]; });
  splits_[node] = {(*middle)[axis], axis};
  split(first, middle, 2 * node);
  split(middle, last, 2 * node + 1);
}

}  // namespace vernier
