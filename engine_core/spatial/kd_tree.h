// The k nearest points, and those within any radius, by a balanced kd-tree (Bentley 1975; for
// photon maps Jensen 2001, section 6.2).
//
// The tree is complete: every node halves its points along the axis in which they spread most, and
// nodes are numbered as in a heap, so that there are no pointers and no tree of any shape is deep.
// The points themselves lie in the order of the leaves: what is near is together in memory.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "math/vec.h"

namespace vernier {

// One of the points that a query found: its place in the tree's order.
struct KdNeighbour {
  float distance_squared;
  uint32_t place;
};

class KdTree {
 public:
  // A tree of nothing.
  KdTree() = default;
  // `positions` finite, each coordinate below 1e18 in size, fewer than 2^32 of them; not kept.
  // Built on up to `threads` threads (0: all there are); the tree does not depend on them.
  KdTree(std::span<const Vec3f> positions, int threads);

  size_t size() const { return points_.size(); }
  // Bytes in use: 16 for each point and 8 for every four to eight.
  size_t memory() const { return points_.size() * sizeof(Point) + nodes_.size() * sizeof(Node); }

  // Points are told by their place in the tree's order, where neighbours are near each other: data
  // of a point are best kept in that order too. `index` is the place in `positions`.
  uint32_t index(uint32_t place) const { return points_[place].index; }
  Vec3f position(uint32_t place) const { return points_[place].p; }

  // Calls visit(place, distance_squared) once for each point with distance_squared at most
  // `radius_squared`, in the order of places.
  template <class Visit>
  void for_each(Vec3f p, float radius_squared, const Visit& visit) const;

  // Fills `found`, which holds at least k >= 1, with the k points nearest to p, or all of them if
  // fewer are closer than `radius_squared`; returns how many. In no order, but with k found the
  // farthest is the first.
  size_t nearest(Vec3f p, size_t k, float radius_squared, std::span<KdNeighbour> found) const;

 private:
  friend class KdTreeBuild;

  struct Point {
    Vec3f p;
    uint32_t index;
  };
  struct Node {
    float split;  // all to the left are not above, all to the right not below
    uint32_t axis;
  };
  // Points of a leaf, at most.
  static constexpr size_t kLeafSize = 8;
  static constexpr size_t kMostLevels = 32;
  // Bounds of distances are sums of rounded squares: lowered by this part, none is too large.
  static constexpr float kRounding = 1.0f - 8.0f * kUnitRoundoff;

  // A subtree yet to be seen: how far its box is from the query's point, along each axis.
  struct Pending {
    size_t node;
    Vec3f away;
    float bound;
  };

  size_t leaves() const { return nodes_.size() + 1; }
  // The first point of a leaf.
  size_t leaf_begin(size_t leaf) const { return points_.size() * leaf / leaves(); }
  // Calls leaf(begin, end) for the leaves whose boxes may hold points within `limit()`, those that
  // are nearest to p in each pair of subtrees first.
  template <class Limit, class Leaf>
  void walk(Vec3f p, const Limit& limit, const Leaf& leaf) const;

  std::vector<Point> points_;  // in the order of leaves
  std::vector<Node> nodes_;    // node i has children 2i + 1 and 2i + 2; leaves follow the last
};

// The tree's construction as stages (stages.h), for threads that have other work as well.
class KdTreeBuild {
 public:
  // Both must outlive the build; as KdTree().
  KdTreeBuild(KdTree& tree, std::span<const Vec3f> positions);

  static constexpr int kMostTopLevels = 6;

  // As many for any number of points: small trees have none of the jobs of some.
  int stages() const { return 2 + kMostTopLevels; }
  size_t jobs(int stage) const;
  void run(int stage, size_t job);

 private:
  void copy(size_t part);
  void split(size_t node, int level);
  void split_below(size_t node, int level);

  KdTree& tree_;
  std::span<const Vec3f> positions_;
  size_t parts_;
  int levels_ = 0;      // of nodes
  int top_levels_ = 0;  // those that are a stage each; the rest is one
};

template <class Limit, class Leaf>
void KdTree::walk(Vec3f p, const Limit& limit, const Leaf& leaf) const {
  if (points_.empty()) {
    return;
  }
  std::array<Pending, kMostLevels> stack;
  size_t waiting = 0;
  Pending here{0, {}, 0.0f};
  for (;;) {
    while (here.node < nodes_.size()) {
      const Node& node = nodes_[here.node];
      const auto axis = static_cast<int>(node.axis);
      const float across = p[axis] - node.split;
      const size_t left = 2 * here.node + 1, right = left + 1;
      Pending far{across < 0.0f ? right : left, here.away, 0.0f};
      far.away[axis] = across;
      far.bound = length_squared(far.away) * kRounding;
      here.node = across < 0.0f ? left : right;
      if (far.bound <= limit()) {
        stack[waiting++] = far;
      }
    }
    const size_t number = here.node - nodes_.size();
    leaf(leaf_begin(number), leaf_begin(number + 1));
    do {
      if (waiting == 0) {
        return;
      }
      here = stack[--waiting];
    } while (here.bound > limit());
  }
}

template <class Visit>
void KdTree::for_each(Vec3f p, float radius_squared, const Visit& visit) const {
  walk(
      p, [&] { return radius_squared; },
      [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
          const float d2 = length_squared(points_[i].p - p);
          if (d2 <= radius_squared) {
            visit(static_cast<uint32_t>(i), d2);
          }
        }
      });
}

}  // namespace vernier
