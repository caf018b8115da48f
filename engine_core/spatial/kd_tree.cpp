#include "spatial/kd_tree.h"

#include <bit>

#include "spatial/stages.h"

namespace vernier {
namespace {

constexpr size_t kPartSize = 65536;

bool closer(const KdNeighbour& a, const KdNeighbour& b) {
  return a.distance_squared < b.distance_squared;
}

// Puts `last` in the place of the farthest of a heap.
void replace_farthest(std::span<KdNeighbour> heap, KdNeighbour last) {
  size_t i = 0;
  for (size_t child = 1; child < heap.size(); child = 2 * i + 1) {
    child += child + 1 < heap.size() && closer(heap[child], heap[child + 1]) ? 1 : 0;
    if (!closer(last, heap[child])) {
      break;
    }
    heap[i] = heap[child];
    i = child;
  }
  heap[i] = last;
}

}  // namespace

KdTree::KdTree(std::span<const Vec3f> positions, int threads) {
  KdTreeBuild build(*this, positions);
  run_stages(build, threads);
}

size_t KdTree::nearest(Vec3f p, size_t k, float radius_squared,
                       std::span<KdNeighbour> found) const {
  const std::span<KdNeighbour> heap = found.first(k);
  size_t count = 0;
  float limit = radius_squared;
  walk(
      p, [&] { return limit; },
      [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
          const KdNeighbour n{length_squared(points_[i].p - p), static_cast<uint32_t>(i)};
          if (!(n.distance_squared <= limit)) {
            continue;
          }
          if (count < k) {
            heap[count++] = n;
            if (count < k) {
              continue;
            }
            std::make_heap(heap.begin(), heap.end(), closer);
          } else {
            replace_farthest(heap, n);
          }
          limit = heap.front().distance_squared;
        }
      });
  return count;
}

KdTreeBuild::KdTreeBuild(KdTree& tree, std::span<const Vec3f> positions)
    : tree_(tree), positions_(positions), parts_((positions.size() + kPartSize - 1) / kPartSize) {
  const size_t leaves =
      std::bit_ceil((positions.size() + KdTree::kLeafSize - 1) / KdTree::kLeafSize);
  levels_ = positions.empty() ? 0 : std::bit_width(leaves) - 1;
  top_levels_ = std::min(levels_, kMostTopLevels);
  tree_.points_.resize(positions.size());
  tree_.nodes_.resize((size_t{1} << levels_) - 1);
}

size_t KdTreeBuild::jobs(int stage) const {
  if (stage == 0) {
    return parts_;
  }
  if (stage <= kMostTopLevels) {
    return stage <= top_levels_ ? size_t{1} << (stage - 1) : 0;
  }
  return levels_ > top_levels_ ? size_t{1} << top_levels_ : 0;
}

void KdTreeBuild::run(int stage, size_t job) {
  if (stage == 0) {
    copy(job);
  } else if (stage <= kMostTopLevels) {
    split((size_t{1} << (stage - 1)) - 1 + job, stage - 1);
  } else {
    split_below((size_t{1} << top_levels_) - 1 + job, top_levels_);
  }
}

void KdTreeBuild::copy(size_t part) {
  const size_t end = std::min((part + 1) * kPartSize, positions_.size());
  for (size_t i = part * kPartSize; i < end; ++i) {
    tree_.points_[i] = {positions_[i], static_cast<uint32_t>(i)};
  }
}

void KdTreeBuild::split(size_t node, int level) {
  // The leaves below the node, and with them its points.
  const size_t width = size_t{1} << (levels_ - level);
  const size_t first = (node + 1 - (size_t{1} << level)) * width;
  const auto at = [&](size_t leaf) {
    return tree_.points_.begin() + static_cast<ptrdiff_t>(tree_.leaf_begin(leaf));
  };
  const auto begin = at(first), middle = at(first + width / 2), end = at(first + width);
  Vec3f low = splat(kInfinity), high = splat(-kInfinity);
  for (auto point = begin; point != end; ++point) {
    low = min(low, point->p);
    high = max(high, point->p);
  }
  const Vec3f size = high - low;
  const int axis = size.x >= size.y ? (size.x >= size.z ? 0 : 2) : (size.y >= size.z ? 1 : 2);
  std::nth_element(begin, middle, end, [&](const KdTree::Point& a, const KdTree::Point& b) {
    return a.p[axis] < b.p[axis];
  });
  tree_.nodes_[node] = {middle->p[axis], static_cast<uint32_t>(axis)};
}

void KdTreeBuild::split_below(size_t node, int level) {
  split(node, level);
  if (level + 1 < levels_) {
    split_below(2 * node + 1, level + 1);
    split_below(2 * node + 2, level + 1);
  }
}

}  // namespace vernier
