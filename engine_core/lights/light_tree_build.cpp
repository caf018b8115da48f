// How a light tree is made: a binary tree by a surface-area-and-orientation heuristic, of which
// eight branches at a time become one node.
#include <algorithm>
#include <bit>
#include <cmath>

#include "lights/light_tree.h"

namespace vernier {
namespace {

Vec3f center_of(const LightBounds& b) { return b.lower * 0.5f + b.upper * 0.5f; }
float diagonal2(const LightBounds& b) { return length_squared(b.upper - b.lower); }

// The measure of the directions that a cone of normals shines to, weighted by the cosine at its
// edge (Conty Estevez and Kulla 2018, equation 1).
float orientation_measure(const LightBounds& b) {
  const float o = b.angle_o;
  const float w = std::min(o + b.angle_e, kPi);
  const float cos_o = std::cos(o);
  const float measure =
      kTwoPi * (1.0f - cos_o) +
      0.5f * kPi * (2.0f * (w - o) * std::sin(o) - std::cos(o - 2.0f * w) + cos_o);
  return b.two_sided ? 2.0f * measure : measure;
}

// What a node costs: intensity times the measure of its directions times its size. The size is the
// square of the diagonal, as in its importance, and not the surface of the box, which is zero for
// lights in a row.
float cost_of(const LightBounds& b) { return b.intensity * orientation_measure(b) * diagonal2(b); }

}  // namespace

LightBounds merge(const LightBounds& a, const LightBounds& b) {
  if (!(a.intensity > 0.0f)) {
    return b;
  }
  if (!(b.intensity > 0.0f)) {
    return a;
  }
  LightBounds r;
  r.lower = min(a.lower, b.lower);
  r.upper = max(a.upper, b.upper);
  r.angle_e = std::max(a.angle_e, b.angle_e);
  r.intensity = a.intensity + b.intensity;
  r.two_sided = a.two_sided || b.two_sided;
  // The cone about both (Conty Estevez and Kulla 2018, section 4.1). What shines both ways may as
  // well be turned around.
  const bool turn = a.two_sided && b.two_sided && dot(a.axis, b.axis) < 0.0f;
  const Vec3f axis_b = turn ? -b.axis : b.axis;
  const bool a_wider = a.angle_o >= b.angle_o;
  const float wide_angle = a_wider ? a.angle_o : b.angle_o;
  const float slim_angle = a_wider ? b.angle_o : a.angle_o;
  r.axis = a_wider ? a.axis : axis_b;
  r.angle_o = wide_angle;
  if (wide_angle >= kPi) {
    return r;
  }
  const Vec3f slim = a_wider ? axis_b : a.axis;
  const Vec3f sideways = slim - r.axis * dot(slim, r.axis);
  const float sine = length(sideways);
  const float between = std::atan2(sine, dot(r.axis, slim));
  if (std::min(between + slim_angle, kPi) <= wide_angle) {
    return r;
  }
  r.angle_o = 0.5f * (wide_angle + between + slim_angle);
  if (r.angle_o >= kPi || !(sine > 0.0f)) {
    r.angle_o = kPi;
    return r;
  }
  const float turn_by = r.angle_o - wide_angle;
  r.axis = normalize(r.axis * std::cos(turn_by) + sideways * (std::sin(turn_by) / sine));
  return r;
}

class LightTreeBuilder {
 public:
  LightTreeBuilder(std::span<const LightBounds> bounds, std::span<const uint32_t> lights,
                   LightTree& tree)
      : bounds_(bounds), lights_(lights), tree_(tree), order_(lights.size()) {
    for (uint32_t i = 0; i < order_.size(); ++i) {
      order_[i] = i;
    }
    branches_.reserve(2 * lights.size() - 1);
    tree_.light_places_.resize(*std::max_element(lights.begin(), lights.end()) + 1u);
    // Past this depth halves are split off, so that degenerate inputs cost no more.
    for (size_t n = lights.size(); n > 1; n /= 2) {
      greedy_depth_ += 2;
    }
    widen(build(0, static_cast<uint32_t>(order_.size()), 0), {});
  }

 private:
  static constexpr int kBins = 12;
  static constexpr uint32_t kSplitSamples = 256;

  // A node of the binary tree that splitting makes, before eight of them become one.
  struct Branch {
    LightBounds bounds;
    uint32_t left = kNoIndex, right = kNoIndex;
    uint32_t light = kNoIndex;  // of a leaf
  };

  uint32_t build(uint32_t begin, uint32_t end, int depth) {
    const auto index = static_cast<uint32_t>(branches_.size());
    branches_.emplace_back();
    if (end - begin == 1) {
      branches_[index].bounds = bounds_[order_[begin]];
      branches_[index].light = lights_[order_[begin]];
      return index;
    }
    const uint32_t middle = split(begin, end, depth);
    const uint32_t left = build(begin, middle, depth + 1);
    const uint32_t right = build(middle, end, depth + 1);
    branches_[index].left = left;
    branches_[index].right = right;
    branches_[index].bounds = merge(branches_[left].bounds, branches_[right].bounds);
    return index;
  }

  // Opens the costliest branches below `branch` until eight are side by side.
  uint32_t widen(uint32_t branch, LightTree::Place place) {
    std::array<uint32_t, LightTree::kWidth> children{branch};
    size_t count = 1;
    while (count < children.size()) {
      size_t widest = count;
      float cost = -1.0f;
      for (size_t i = 0; i < count; ++i) {
        const Branch& child = branches_[children[i]];
        // The root is opened whatever it costs.
        if (child.light == kNoIndex && !(cost_of(child.bounds) <= cost)) {
          widest = i;
          cost = cost_of(child.bounds);
        }
      }
      if (widest == count) {
        break;
      }
      const Branch& open = branches_[children[widest]];
      children[widest] = open.left;
      children[count++] = open.right;
    }
    const auto node = static_cast<uint32_t>(tree_.nodes_.size());
    tree_.nodes_.emplace_back();
    tree_.node_places_.push_back(place);
    for (uint32_t lane = 0; lane < count; ++lane) {
      const Branch& child = branches_[children[lane]];
      const bool is_light = child.light != kNoIndex;
      const uint32_t link = is_light ? child.light : widen(children[lane], {node, lane});
      store(tree_.nodes_[node], lane, child.bounds, link, is_light);
      if (is_light) {
        tree_.light_places_[child.light] = {node, lane};
      }
    }
    return node;
  }

  uint32_t split(uint32_t begin, uint32_t end, int depth) {
    Vec3f lower = splat(kInfinity), upper = splat(-kInfinity);
    for (uint32_t i = begin; i < end; ++i) {
      const Vec3f c = center_of(bounds_[order_[i]]);
      lower = min(lower, c);
      upper = max(upper, c);
    }
    const Vec3f extent = upper - lower;
    int widest = 0;
    for (int axis = 1; axis < 3; ++axis) {
      widest = extent[axis] > extent[widest] ? axis : widest;
    }
    if (!(extent[widest] > 0.0f)) {
      return begin + (end - begin) / 2;
    }
    if (depth < greedy_depth_ && end - begin > 2) {
      float best_cost = kInfinity;
      int best_axis = -1, best_bin = 0;
      for (int axis = 0; axis < 3; ++axis) {
        if (extent[axis] > 0.0f) {
          find_best(begin, end, axis, lower[axis], extent[axis], extent[widest], best_cost,
                    best_axis, best_bin);
        }
      }
      if (best_axis >= 0) {
        const auto middle =
            std::partition(order_.begin() + begin, order_.begin() + end, [&](uint32_t light) {
              return bin_of(light, best_axis, lower[best_axis], extent[best_axis]) <= best_bin;
            });
        return static_cast<uint32_t>(middle - order_.begin());
      }
    }
    const uint32_t middle = begin + (end - begin) / 2;
    std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                     [&](uint32_t a, uint32_t b) {
                       return center_of(bounds_[a])[widest] < center_of(bounds_[b])[widest];
                     });
    return middle;
  }

  int bin_of(uint32_t light, int axis, float lower, float extent) const {
    const float x = (center_of(bounds_[light])[axis] - lower) / extent;
    // Where the extent is beyond float32, no quotient tells places apart: it may be no number.
    return x > 0.0f ? static_cast<int>(std::min(x * kBins, kBins - 1.0f)) : 0;
  }

  void find_best(uint32_t begin, uint32_t end, int axis, float lower, float extent,
                 float widest_extent, float& best_cost, int& best_axis, int& best_bin) const {
    std::array<LightBounds, kBins> bins;
    std::array<uint32_t, kBins> counts{};
    // Of many lights, every so many tell where to split.
    const uint32_t stride = std::max((end - begin) / kSplitSamples, 1u);
    uint32_t sampled = 0;
    for (uint32_t i = begin; i < end; i += stride) {
      const auto bin = static_cast<size_t>(bin_of(order_[i], axis, lower, extent));
      bins[bin] = merge(bins[bin], bounds_[order_[i]]);
      ++counts[bin];
      ++sampled;
    }
    std::array<float, kBins> right_cost{};
    LightBounds right;
    for (size_t bin = kBins - 1; bin > 0; --bin) {
      if (counts[bin] > 0) {
        right = merge(right, bins[bin]);
        right_cost[bin] = cost_of(right);
      } else if (bin + 1 < kBins) {
        right_cost[bin] = right_cost[bin + 1];
      }
    }
    LightBounds left;
    uint32_t left_count = 0;
    // Thin boxes are discouraged (Conty Estevez and Kulla 2018, equation 2).
    const float regularity = widest_extent / extent;
    for (size_t bin = 0; bin + 1 < kBins; ++bin) {
      if (counts[bin] == 0) {
        continue;
      }
      left = merge(left, bins[bin]);
      left_count += counts[bin];
      if (left_count == sampled) {
        break;
      }
      const float cost = regularity * (cost_of(left) + right_cost[bin + 1]);
      if (cost < best_cost) {
        best_cost = cost;
        best_axis = axis;
        best_bin = static_cast<int>(bin);
      }
    }
  }

  // The upper half of the float32 next to `number`, or next below.
  static uint32_t nearest_half(float number) {
    return (std::bit_cast<uint32_t>(number) + 0x8000u) >> 16;
  }
  static uint32_t half_below(float number) {
    const uint32_t bits = std::bit_cast<uint32_t>(number);
    return (bits >> 16) + ((bits >> 31) != 0 && (bits & 0xffffu) != 0 ? 1u : 0u);
  }
  // The word of the given lower half that is, as a float32, next to `number`, which becomes at
  // least `least`: denormals are slow.
  static uint32_t nearest_word(float number, uint32_t low, float least = 0x1p-20f) {
    const float normal = std::copysign(std::max(std::abs(number), least), number);
    return ((std::bit_cast<uint32_t>(normal) - low + 0x8000u) & 0xffff0000u) | low;
  }

  static void store(LightTree::Node& node, size_t lane, const LightBounds& b, uint32_t link,
                    bool is_light) {
    const Vec3f center = center_of(b);
    node.center_x[lane] = center.x, node.center_y[lane] = center.y, node.center_z[lane] = center.z;
    // With the rounding of the centre, and all that a height over a receiver's plane may be off by
    // but for the receiver's own place.
    const float radius = length(max(b.upper - center, center - b.lower)) * (1.0f + gamma(20)) +
                         length(center) * gamma(16);
    node.radius_cos_e[lane] = nearest_word(radius, half_below(std::cos(b.angle_e)), 1e-18f);
    store_cone(node, lane, b);
    node.child[lane] = is_light ? link | LightTree::kIsLight : link;
  }

  static void store_cone(LightTree::Node& node, size_t lane, const LightBounds& b) {
    constexpr float kRounding = 0x1p-8f;
    const bool all_around = b.axis == Vec3f{};
    const Vec3f axis = all_around ? Vec3f{0, 0, 1} : b.axis;
    uint32_t x = 0, y = 0, z = nearest_half(b.two_sided ? -b.intensity : b.intensity);
    // Each time with what the lower halves have become: the first is without.
    for (int i = 0; i < 4; ++i) {
      x = nearest_word(-axis.x, x & 0xffffu);
      y = nearest_word(-axis.y, y & 0xffffu);
      z = nearest_word(-axis.z, z & 0xffffu);
      const Vec3f stored =
          -Vec3f{std::bit_cast<float>(x), std::bit_cast<float>(y), std::bit_cast<float>(z)};
      // Wider by what the axis has turned and the cone will be rounded; and never of sine zero: by
      // the sign of sin(w - o), a cone of all directions contains its axis.
      const float turned = std::atan2(length(cross(axis, stored)), dot(axis, stored));
      const float angle = all_around ? kPi : std::min(b.angle_o + turned + kRounding, kPi);
      const float scale = 1.0f / length(stored);
      if (i < 3) {
        x = nearest_half(std::cos(angle) * scale);
        y = nearest_half(std::max(std::sin(angle), 0x1p-10f) * scale);
      }
    }
    node.axis_x_cos_o[lane] = x;
    node.axis_y_sin_o[lane] = y;
    node.axis_z_intensity[lane] = z;
  }

  std::span<const LightBounds> bounds_;
  std::span<const uint32_t> lights_;
  LightTree& tree_;
  std::vector<uint32_t> order_;
  std::vector<Branch> branches_;
  int greedy_depth_ = 8;
};

LightTree::LightTree(std::span<const LightBounds> bounds, std::span<const uint32_t> lights) {
  if (!lights.empty()) {
    const LightTreeBuilder builder(bounds, lights, *this);
  }
}

}  // namespace vernier
