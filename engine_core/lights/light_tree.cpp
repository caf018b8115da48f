#include "lights/light_tree.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace vernier {
namespace {

constexpr int16_t kAxisUnits = 32767;
constexpr float kAxisScale = kAxisUnits;
// Cosines here come from square roots of rounded differences: they are good to sqrt(u).
constexpr float kCosineSlack = 0x1p-10f;
// Least share of a branch that reaches the receiver at all: an importance is a guess that knows
// nothing of occlusion.
constexpr float kLeastShare = 0x1p-12f;
// Subtrees this small are weighed light by light: bounds of a few lights that point elsewhere often
// promise what none of them keeps, and the choice would be wasted.
constexpr uint32_t kExactLeaves = 4;

float sine_of(float cosine) { return safe_sqrt(1.0f - cosine * cosine); }

// cos and sin of max(a - b, 0), from the cosines and sines of a and b in [0, pi].
struct Angle {
  float cosine, sine;
};
Angle subtract(Angle a, Angle b) {
  if (a.cosine >= b.cosine) {
    return {1.0f, 0.0f};
  }
  return {a.cosine * b.cosine + a.sine * b.sine, a.sine * b.cosine - a.cosine * b.sine};
}

// cos of max(a - b, 0), from the cosine of a in [0, pi].
float least_cosine(float cos_a, Angle b) {
  return cos_a >= b.cosine ? 1.0f : cos_a * b.cosine + sine_of(cos_a) * b.sine;
}

// True where all of a box lies behind the plane through p with normal n.
bool box_behind(Vec3f center, Vec3f half, Vec3f p, Vec3f n) {
  const Vec3f a = abs(n);
  const float highest = dot(n, center - p) + dot(a, half);
  const float rounding = gamma(16) * dot(a, abs(center) + abs(p) + half);
  return highest < -rounding;
}

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

float LightTree::node_importance(const Node& node, const Receiver& from) {
  if (!from.transmits && box_behind(node.center, node.half, from.p, from.ng)) {
    return 0.0f;
  }
  const Vec3f to = node.center - from.p;
  const float distance2 = length_squared(to);
  const float radius2 = length_squared(node.half);
  float cosines = 1.0f;
  if (distance2 > radius2) {
    const Vec3f direction = to * (1.0f / std::sqrt(distance2));
    // The angle that the sphere about the box fills.
    const float sin2_b = radius2 / distance2;
    const Angle b{std::sqrt(1.0f - sin2_b), std::sqrt(sin2_b)};
    // The least angle between the light and the receiver's normal.
    const float cos_i = dot(from.ns, direction);
    cosines =
        std::max(least_cosine(from.transmits ? std::abs(cos_i) : cos_i, b), kImportanceCosineFloor);
    if (node.cos_o > -kAxisUnits) {
      // The least angle between a normal of the lights and the receiver.
      constexpr float unit = 1.0f / static_cast<float>(kAxisUnits);
      const Vec3f axis{static_cast<float>(node.axis[0]), static_cast<float>(node.axis[1]),
                       static_cast<float>(node.axis[2])};
      float cos_w = clamp(-unit * dot(axis, direction), -1.0f, 1.0f);
      cos_w = node.two_sided != 0 ? std::abs(cos_w) : cos_w;
      const Angle o{unit * static_cast<float>(node.cos_o), unit * static_cast<float>(node.sin_o)};
      const Angle x = subtract({cos_w, sine_of(cos_w)}, o);
      const float cos_x = x.cosine >= b.cosine ? 1.0f : x.cosine * b.cosine + x.sine * b.sine;
      if (cos_x < unit * static_cast<float>(node.cos_e) - kCosineSlack) {
        return 0.0f;
      }
      cosines *= std::max(cos_x, kImportanceCosineFloor);
    }
  }
  return clamp(node.intensity * cosines / std::max(distance2, radius2), kSmallestImportance,
               kLargestImportance);
}

float LightTree::weight(uint32_t node, uint32_t leaves, const Receiver& from) const {
  if (leaves > kExactLeaves) {
    return node_importance(nodes_[node], from);
  }
  float sum = 0.0f;
  for (uint32_t i = node; i < node + 2 * leaves - 1; ++i) {
    if (nodes_[i].is_leaf) {
      sum += node_importance(nodes_[i], from);
    }
  }
  return sum;
}

float LightTree::left_probability(uint32_t node, uint32_t leaves, const Receiver& from) const {
  const uint32_t left_leaves = (nodes_[node].link - node) / 2;
  const float left = weight(node + 1, left_leaves, from);
  const float right = weight(nodes_[node].link, leaves - left_leaves, from);
  if (!(left > 0.0f)) {
    return right > 0.0f ? 0.0f : -1.0f;
  }
  return right > 0.0f ? clamp(left / (left + right), kLeastShare, 1.0f - kLeastShare) : 1.0f;
}

// A subtree of n leaves has 2 n - 1 nodes, the first of which is its root: the number of leaves on
// the left follows from the right child's place, and the rank of a light tells the way to it.

uint32_t LightTree::sample(const Receiver& from, double u, float& pdf) const {
  pdf = 1.0f;
  uint32_t node = 0;
  auto leaves = static_cast<uint32_t>((nodes_.size() + 1) / 2);
  while (leaves > 1) {
    const float left = left_probability(node, leaves, from);
    if (left < 0.0f) {
      return kNoIndex;
    }
    const uint32_t right_child = nodes_[node].link;
    const uint32_t left_leaves = (right_child - node) / 2;
    if (u < static_cast<double>(left)) {
      u /= static_cast<double>(left);
      pdf *= left;
      leaves = left_leaves;
      node = node + 1;
    } else {
      u = (u - static_cast<double>(left)) / (1.0 - static_cast<double>(left));
      pdf *= 1.0f - left;
      leaves -= left_leaves;
      node = right_child;
    }
  }
  return nodes_[node].link;
}

float LightTree::pdf(const Receiver& from, uint32_t light) const {
  float pdf = 1.0f;
  uint32_t node = 0;
  auto leaves = static_cast<uint32_t>((nodes_.size() + 1) / 2);
  uint32_t rank = rank_[light];
  while (leaves > 1) {
    const float left = left_probability(node, leaves, from);
    if (left < 0.0f) {
      return 0.0f;
    }
    const uint32_t right_child = nodes_[node].link;
    const uint32_t left_leaves = (right_child - node) / 2;
    if (rank < left_leaves) {
      pdf *= left;
      leaves = left_leaves;
      node = node + 1;
    } else {
      pdf *= 1.0f - left;
      rank -= left_leaves;
      leaves -= left_leaves;
      node = right_child;
    }
    if (pdf == 0.0f) {
      return 0.0f;
    }
  }
  return pdf;
}

// Splits by binned surface area and orientation, O(n log n).
class LightTreeBuilder {
 public:
  LightTreeBuilder(std::span<const LightBounds> bounds, std::span<const uint32_t> lights,
                   LightTree& tree)
      : bounds_(bounds), lights_(lights), tree_(tree), order_(lights.size()) {
    for (uint32_t i = 0; i < order_.size(); ++i) {
      order_[i] = i;
    }
    tree_.nodes_.reserve(2 * lights.size() - 1);
    tree_.rank_.assign(*std::max_element(lights.begin(), lights.end()) + 1u, kNoIndex);
    // Past this depth halves are split off, so that degenerate inputs cost no more.
    for (size_t n = lights.size(); n > 1; n /= 2) {
      greedy_depth_ += 2;
    }
    build(0, static_cast<uint32_t>(order_.size()), 0);
  }

 private:
  static constexpr int kBins = 12;
  static constexpr uint32_t kSplitSamples = 256;

  LightBounds build(uint32_t begin, uint32_t end, int depth) {
    const auto node = static_cast<uint32_t>(tree_.nodes_.size());
    tree_.nodes_.emplace_back();
    if (end - begin == 1) {
      const LightBounds& leaf = bounds_[order_[begin]];
      const uint32_t light = lights_[order_[begin]];
      tree_.rank_[light] = begin;
      store(node, leaf, light, true);
      return leaf;
    }
    const uint32_t middle = split(begin, end, depth);
    const LightBounds left = build(begin, middle, depth + 1);
    const auto right_child = static_cast<uint32_t>(tree_.nodes_.size());
    const LightBounds right = build(middle, end, depth + 1);
    const LightBounds both = merge(left, right);
    store(node, both, right_child, false);
    return both;
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
    if (depth < greedy_depth_ && end - begin > kExactLeaves) {
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
    return std::min(static_cast<int>(x * static_cast<float>(kBins)), kBins - 1);
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

  void store(uint32_t index, const LightBounds& b, uint32_t link, bool is_leaf) {
    LightTree::Node& node = tree_.nodes_[index];
    node.center = center_of(b);
    // Half the size, with the rounding of the centre.
    node.half = max(b.upper - node.center, node.center - b.lower) * (1.0f + gamma(4));
    for (int c = 0; c < 3; ++c) {
      node.axis[static_cast<size_t>(c)] = static_cast<int16_t>(std::lround(b.axis[c] * kAxisScale));
    }
    // A direction that rounds by half a unit in each of three components turns by less than one
    // unit: a cosine falls by less than that and the unit of its own rounding.
    const auto below = [](float cosine) {
      return static_cast<int16_t>(std::max(std::floor(cosine * kAxisScale) - 2.0f, -kAxisScale));
    };
    // Of the lowered cosine the sine too: the cone is that much wider. -1: shines all around.
    node.cos_o = b.angle_o >= kPi ? static_cast<int16_t>(-kAxisUnits) : below(std::cos(b.angle_o));
    const float cos_o = static_cast<float>(node.cos_o) / kAxisScale;
    node.sin_o = static_cast<int16_t>(std::lround(kAxisScale * sine_of(cos_o)));
    node.cos_e = below(std::cos(b.angle_e));
    node.two_sided = b.two_sided ? 1 : 0;
    node.is_leaf = is_leaf ? 1 : 0;
    node.intensity = b.intensity;
    node.link = link;
  }

  std::span<const LightBounds> bounds_;
  std::span<const uint32_t> lights_;
  LightTree& tree_;
  std::vector<uint32_t> order_;
  int greedy_depth_ = 8;
};

LightTree::LightTree(std::span<const LightBounds> bounds, std::span<const uint32_t> lights) {
  if (!lights.empty()) {
    const LightTreeBuilder builder(bounds, lights, *this);
  }
}

}  // namespace vernier
