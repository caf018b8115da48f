#include "lights/lamp_bvh.h"

#include <algorithm>

namespace vernier {

LampBvh::LampBvh(std::span<const LampBox> lamps) {
  if (!lamps.empty()) {
    std::vector<LampBox> boxes(lamps.begin(), lamps.end());
    nodes_.reserve(2 * boxes.size() - 1);
    build(boxes);
  }
}

// Halves at the median of the longest axis: depth is logarithmic whatever the lamps.
void LampBvh::build(std::span<LampBox> lamps) {
  const size_t index = nodes_.size();
  nodes_.emplace_back();
  Vec3f lower = splat(kInfinity), upper = splat(-kInfinity);
  for (const LampBox& lamp : lamps) {
    lower = min(lower, lamp.lower);
    upper = max(upper, lamp.upper);
  }
  if (lamps.size() == 1) {
    nodes_[index].lamp = lamps[0].lamp;
  } else {
    const Vec3f extent = upper - lower;
    const int axis =
        extent.x > extent.y ? (extent.x > extent.z ? 0 : 2) : (extent.y > extent.z ? 1 : 2);
    const size_t half = lamps.size() / 2;
    std::nth_element(lamps.begin(), lamps.begin() + static_cast<ptrdiff_t>(half), lamps.end(),
                     [axis](const LampBox& a, const LampBox& b) {
                       return 0.5f * a.lower[axis] + 0.5f * a.upper[axis] <
                              0.5f * b.lower[axis] + 0.5f * b.upper[axis];
                     });
    build(lamps.subspan(0, half));
    build(lamps.subspan(half));
  }
  Node& node = nodes_[index];
  // Planes a little outside of what the lamp's own intersection may round to.
  const Vec3f slack = (abs(lower) + abs(upper)) * gamma(8);
  node.lower = lower - slack;
  node.upper = upper + slack;
  node.skip = static_cast<uint32_t>(nodes_.size());
}

}  // namespace vernier
