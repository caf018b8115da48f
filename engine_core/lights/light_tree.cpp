#include "lights/light_tree.h"

#include <cmath>

namespace vernier {
namespace {

// Cosines here come from square roots of rounded differences: they are good to sqrt(u).
constexpr float kCosineSlack = 0x1p-10f;
// Least share of a branch that reaches the receiver at all: an importance is a guess that knows
// nothing of occlusion.
constexpr float kLeastShare = 0x1p-12f;

}  // namespace

// Every lane does the same, without a branch, so that the loop becomes vector instructions.
float LightTree::weigh(const Node& node, const Receiver& from, Lanes& weights) {
  const Vec3f p = from.p, ng = from.ng, ns = from.ns;
  const Vec3f a = abs(ng);
  const float floor_p = dot(a, abs(p));
  const float opaque = from.transmits ? 0.0f : 1.0f;
  for (size_t i = 0; i < kWidth; ++i) {
    const float x = node.center_x[i] - p.x;
    const float y = node.center_y[i] - p.y;
    const float z = node.center_z[i] - p.z;
    const float distance2 = x * x + y * y + z * z;
    const float half_x = node.half_x[i], half_y = node.half_y[i], half_z = node.half_z[i];
    const float radius2 = half_x * half_x + half_y * half_y + half_z * half_z;
    const float nearest = std::max(distance2, radius2);
    const float outside = distance2 > radius2 ? 1.0f : 0.0f;

    // Nothing where all of the box lies behind the plane of an opaque receiver.
    const float reach = a.x * half_x + a.y * half_y + a.z * half_z;
    const float highest = ng.x * x + ng.y * y + ng.z * z + reach;
    const float size = a.x * std::abs(node.center_x[i]) + a.y * std::abs(node.center_y[i]) +
                       a.z * std::abs(node.center_z[i]) + floor_p + reach;
    const float behind = highest < -gamma(16) * size ? opaque : 0.0f;

    const float inverse = 1.0f / std::sqrt(std::max(nearest, std::numeric_limits<float>::min()));
    const float dx = x * inverse, dy = y * inverse, dz = z * inverse;
    // The angle b that the sphere about the box fills.
    const float sin2_b = std::min(radius2 * inverse * inverse, 1.0f);
    const float sin_b = std::sqrt(sin2_b), cos_b = std::sqrt(1.0f - sin2_b);
    // The least angle between the light and the receiver's normal: i less b.
    const float cos_n = ns.x * dx + ns.y * dy + ns.z * dz;
    const float cos_i = opaque > 0.0f ? cos_n : std::abs(cos_n);
    const float sin_i = std::sqrt(std::max(1.0f - cos_i * cos_i, 0.0f));
    const float cos_ib = cos_i >= cos_b ? 1.0f : cos_i * cos_b + sin_i * sin_b;
    // The least angle between a normal of the lights and the receiver: w less o less b.
    const float cos_a = std::min(
        std::max(-(node.axis_x[i] * dx + node.axis_y[i] * dy + node.axis_z[i] * dz), -1.0f), 1.0f);
    const float cos_w = node.one_sided[i] > 0.0f ? cos_a : std::abs(cos_a);
    const float sin_w = std::sqrt(1.0f - cos_w * cos_w);
    const float cos_o = node.cos_o[i], sin_o = node.sin_o[i];
    const bool within = cos_w >= cos_o;
    const float cos_wo = within ? 1.0f : cos_w * cos_o + sin_w * sin_o;
    const float sin_wo = within ? 0.0f : sin_w * cos_o - cos_w * sin_o;
    const float cos_x = cos_wo >= cos_b ? 1.0f : cos_wo * cos_b + sin_wo * sin_b;
    const float dark = cos_x < node.cos_e[i] - kCosineSlack ? outside : 0.0f;

    const float cosines =
        std::max(cos_ib, kImportanceCosineFloor) * std::max(cos_x, kImportanceCosineFloor);
    const float weighted = node.intensity[i] * (outside > 0.0f ? cosines : 1.0f) /
                           std::max(nearest, std::numeric_limits<float>::min());
    const float bounded = std::min(std::max(weighted, kSmallestImportance), kLargestImportance);
    const bool reaches = node.intensity[i] > 0.0f && behind + dark == 0.0f;
    weights[i] = reaches ? bounded : 0.0f;
  }
  float sum = 0.0f;
  for (const float weight : weights) {
    sum += weight;
  }
  return sum;
}

float LightTree::importance(const Receiver& from) const {
  Lanes weights;
  return empty() ? 0.0f : weigh(nodes_[0], from, weights);
}

// A child's probability is its weight's share of the sum, of which a little goes evenly to all that
// have any: w (1 - k) / sum + k / count.
uint32_t LightTree::sample(const Receiver& from, double u, float& pdf) const {
  pdf = 1.0f;
  Lanes weights;
  for (uint32_t node = 0;;) {
    const float sum = weigh(nodes_[node], from, weights);
    if (!(sum > 0.0f)) {
      return kNoIndex;
    }
    float alive = 0.0f;
    for (const float weight : weights) {
      alive += weight > 0.0f ? 1.0f : 0.0f;
    }
    const float scale = (1.0f - kLeastShare) / sum, even = kLeastShare / alive;
    // passed[i]: the shares of the children before i. No branch, as none could be foretold.
    Lanes shares;
    std::array<double, kWidth> passed;
    for (size_t i = 0; i < kWidth; ++i) {
      shares[i] = weights[i] > 0.0f ? weights[i] * scale + even : 0.0f;
    }
    passed[0] = 0.0;
    size_t chosen = 0;
    for (size_t i = 1; i < kWidth; ++i) {
      passed[i] = passed[i - 1] + static_cast<double>(shares[i - 1]);
      chosen += u >= passed[i] ? 1 : 0;
    }
    // The last child with any weight takes what rounding leaves.
    while (!(shares[chosen] > 0.0f)) {
      --chosen;
    }
    u = std::min((u - passed[chosen]) / static_cast<double>(shares[chosen]), 0x1.fffffffffffffp-1);
    pdf *= shares[chosen];
    if (nodes_[node].is_light[chosen]) {
      return nodes_[node].child[chosen];
    }
    node = nodes_[node].child[chosen];
  }
}

float LightTree::pdf(const Receiver& from, uint32_t light) const {
  if (light >= light_places_.size() || light_places_[light].node == kNoIndex) {
    return 0.0f;
  }
  float pdf = 1.0f;
  Lanes weights;
  for (Place at = light_places_[light]; at.node != kNoIndex; at = node_places_[at.node]) {
    const float sum = weigh(nodes_[at.node], from, weights);
    const float weight = weights[at.lane];
    if (!(weight > 0.0f)) {
      return 0.0f;
    }
    float alive = 0.0f;
    for (const float w : weights) {
      alive += w > 0.0f ? 1.0f : 0.0f;
    }
    pdf *= weight * ((1.0f - kLeastShare) / sum) + kLeastShare / alive;
  }
  return pdf;
}

}  // namespace vernier
