// The lamps that a ray may cross.
#pragma once

#include <span>
#include <vector>

#include "embree/intersector.h"
#include "math/vec.h"
#include "scene/surface_point.h"

namespace vernier {

// A box around a lamp.
struct LampBox {
  Vec3f lower, upper;
  uint32_t lamp = 0;
};

// A bounding volume hierarchy in preorder whose nodes know where to go on when they are missed: it
// is walked without a stack, and a walk can pause at every lamp.
class LampBvh {
 public:
  LampBvh() = default;
  explicit LampBvh(std::span<const LampBox> lamps);

  // The next lamp whose box the ray meets before its end, at or after `position`, which moves past
  // it; kNoIndex after the last. A walk begins at position 0.
  uint32_t next(const Ray& ray, Vec3f inverse_direction, uint32_t& position) const {
    while (position < nodes_.size()) {
      const Node& node = nodes_[position];
      if (!meets(node, ray, inverse_direction)) {
        position = node.skip;
        continue;
      }
      ++position;
      if (node.lamp != kNoIndex) {
        return node.lamp;
      }
    }
    return kNoIndex;
  }

 private:
  struct Node {
    Vec3f lower, upper;
    uint32_t skip = 0;         // the node after this subtree
    uint32_t lamp = kNoIndex;  // of a leaf
  };

  // Slabs (Kay and Kajiya 1986). Where the direction lies in a slab's plane the products are
  // infinite or, on the plane itself, not a number, which the order of arguments passes over.
  static bool meets(const Node& node, const Ray& ray, Vec3f inverse) {
    const Vec3f a = (node.lower - ray.o) * inverse, b = (node.upper - ray.o) * inverse;
    float near = 0.0f, far = ray.t_max;
    for (int i = 0; i < 3; ++i) {
      near = std::max(near, std::min(a[i], b[i]));
      far = std::min(far, std::max(a[i], b[i]));
    }
    // The rounding of three operations (Ize 2013, "Robust BVH Ray Traversal").
    return near <= far * (1.0f + 2.0f * gamma(3));
  }

  void build(std::span<LampBox> lamps);

  std::vector<Node> nodes_;
};

}  // namespace vernier
