#include "lights/light_tree.h"

#include <bit>
#include <cmath>

namespace vernier {
namespace {

// Radii are good to a part in 2^9. Cosines come from square roots of rounded differences, which are
// good to sqrt(u), from radii and from other numbers of as many bits.
constexpr float kRadiusSlack = 1.0f + 0x1p-8f;
constexpr float kCosineSlack = 0x1p-7f;
// Squares of distances are at least this, so that no importance overflows.
constexpr float kSmallestDistance2 = 1e-28f;
// Part of a choice that each branch gets that reaches the receiver at all: an importance is a guess
// that knows nothing of occlusion.
constexpr float kLeastShare = 0x1p-15f;

float upper(uint32_t word) { return std::bit_cast<float>(word); }
float lower(uint32_t word) { return std::bit_cast<float>(word << 16); }
float masked(float value, uint32_t mask) {
  return std::bit_cast<float>(std::bit_cast<uint32_t>(value) & mask);
}

// Of every number, its sum with those before.
Floats4 running_sum(Floats4 v) {
  v += __builtin_shufflevector(Floats4{}, v, 0, 4, 5, 6);
  return v + __builtin_shufflevector(Floats4{}, v, 0, 1, 4, 5);
}

// The length of a child's part of the choice; 0: nothing of it reaches the receiver.
float share_of(const LightTree::Choice& choice, size_t i) {
  const float share = choice.end(i) - choice.begin(i);
  // Where nothing was added, sums of the same numbers in another order may differ.
  return share > 0.5f * kLeastShare * choice.sum() ? share : 0.0f;
}

// The child whose part holds u times the sum.
size_t find(const LightTree::Choice& choice, double u) {
  const Floats4 about = Floats4{} + static_cast<float>(u) * choice.sum();
  // Minus how many ends are passed.
  Ints4 passed = (about >= choice.ends[1]) + (about >= choice.ends[2]);
  passed += __builtin_shufflevector(passed, passed, 2, 3, 0, 1);
  auto i = std::min(static_cast<size_t>(-(passed[0] + passed[1])), size_t{LightTree::kWidth - 1});
  // Rounding may have passed an end, which hardly ever happens, and must not to children of a small
  // share more often than to others. What is looked for stays below the last end however it rounds.
  constexpr double kBelowOne = 0x1.ffffffffffffep-1;
  const double exactly = std::min(u, kBelowOne) * static_cast<double>(choice.sum());
  while (i > 0 && exactly < static_cast<double>(choice.begin(i))) {
    --i;
  }
  while (i + 1 < LightTree::kWidth && exactly >= static_cast<double>(choice.end(i))) {
    ++i;
  }
  return i;
}

}  // namespace

LightTree::Query::Query(const Receiver& from) {
  p_x.fill(from.p.x), p_y.fill(from.p.y), p_z.fill(from.p.z);
  ng_x.fill(from.ng.x), ng_y.fill(from.ng.y), ng_z.fill(from.ng.z);
  ns_x.fill(from.ns.x), ns_y.fill(from.ns.y), ns_z.fill(from.ns.z);
  lowest.fill(from.transmits ? -kLarge : -gamma(16) * dot(abs(from.ng), abs(from.p)));
  sides.fill(from.transmits ? ~kSign : ~0u);
}

// Every lane does the same, without a branch, so that the loop becomes vector instructions. Sines
// and cosines are on the scale of the distance, times which they are: their square roots wait
// neither for the distance's nor for its reciprocal.
//
// Never inlined: sample() and pdf() must find the same bits.
[[gnu::noinline]] LightTree::Choice LightTree::weigh(const Node& node, const Query& from) {
  std::array<float, kWidth> weights;
  for (size_t i = 0; i < kWidth; ++i) {
    const float x = node.center_x[i] - from.p_x[i];
    const float y = node.center_y[i] - from.p_y[i];
    const float z = node.center_z[i] - from.p_z[i];
    const float distance2 = x * x + y * y + z * z;
    const float radius = upper(node.radius_cos_e[i]);
    const float radius2 = radius * radius;
    const float nearest = std::max(distance2, radius2);
    const float inverse2 = 1.0f / std::max(nearest, kSmallestDistance2);

    // Nothing where all of the sphere lies behind the plane of an opaque receiver.
    const float highest =
        from.ng_x[i] * x + from.ng_y[i] * y + from.ng_z[i] * z + radius * kRadiusSlack;

    // The sphere fills an angle b, whose sine is the radius: all where the receiver is inside.
    const float cos_b =
        distance2 > radius2 ? std::sqrt(std::max(distance2 - radius2, 0.0f)) : -kLarge;
    // The least angle between the light and the receiver's normal: i less b.
    const float cos_i =
        masked(from.ns_x[i] * x + from.ns_y[i] * y + from.ns_z[i] * z, from.sides[i]);
    const float sin_i = std::sqrt(std::max(nearest - cos_i * cos_i, 0.0f));
    const float cos_ib = cos_i >= cos_b ? 1.0f : (cos_i * cos_b + sin_i * radius) * inverse2;
    // The least angle between a normal of the lights and the receiver: w less o less b.
    const float axis_x = upper(node.axis_x_cos_o[i]);
    const float axis_y = upper(node.axis_y_sin_o[i]);
    const float axis_z = upper(node.axis_z_intensity[i]);
    const float axis2 = axis_x * axis_x + axis_y * axis_y + axis_z * axis_z;
    const float intensity = lower(node.axis_z_intensity[i]);
    const uint32_t two_sided = std::bit_cast<uint32_t>(intensity) & kSign;
    const float cos_w = masked(axis_x * x + axis_y * y + axis_z * z, ~two_sided);
    const float sin_w = std::sqrt(std::max(nearest * axis2 - cos_w * cos_w, 0.0f));
    const float cos_o = lower(node.axis_x_cos_o[i]);
    const float sin_o = lower(node.axis_y_sin_o[i]);
    const float cos_wo = cos_w * cos_o + sin_w * sin_o;
    const float sin_wo = sin_w * cos_o - cos_w * sin_o;
    const bool within = sin_wo < 0.0f || cos_wo >= cos_b;
    const float cos_x = within ? 1.0f : (cos_wo * cos_b + sin_wo * radius) * inverse2;
    const float cos_e = lower(node.radius_cos_e[i]) - kCosineSlack;

    const float cosines =
        std::max(cos_ib, kImportanceCosineFloor) * std::max(cos_x, kImportanceCosineFloor);
    const float weight =
        std::max(masked(intensity, ~kSign) * inverse2 * cosines, kSmallestImportance);
    weights[i] = highest < from.lowest[i] || cos_x < cos_e ? 0.0f : weight;
  }

  const auto low = std::bit_cast<std::array<Floats4, 2>>(weights)[0];
  const auto high = std::bit_cast<std::array<Floats4, 2>>(weights)[1];
  const Floats4 sum_low = running_sum(low);
  const Floats4 sum_high = running_sum(high) + sum_low[3];
  const Floats4 count_low = running_sum(low > 0.0f ? Floats4{} + 1.0f : Floats4{});
  const Floats4 count_high = running_sum(high > 0.0f ? Floats4{} + 1.0f : Floats4{}) + count_low[3];
  const float least = sum_high[3] * kLeastShare;
  return {{Floats4{}, sum_low + count_low * least, sum_high + count_high * least}};
}

LightTree::Choice LightTree::choose_first(const Query& from) const {
  return empty() ? Choice{} : weigh(nodes_[0], from);
}

uint32_t LightTree::sample(const Query& from, const Choice& first, double u, float& pdf) const {
  pdf = 1.0f;
  Choice choice = first;
  for (uint32_t node = 0;;) {
    const float sum = choice.sum();
    if (!(sum > 0.0f)) {
      return kNoIndex;
    }
    const size_t chosen = find(choice, u);
    const uint32_t child = nodes_[node].child[chosen];
    const float share = share_of(choice, chosen);
    pdf *= share / sum;
    if ((child & kIsLight) != 0) {
      return child == kNoIndex ? kNoIndex : child & ~kIsLight;
    }
    // Where in the child's part it was chooses the next.
    u = (u * static_cast<double>(sum) - static_cast<double>(choice.begin(chosen))) /
        static_cast<double>(choice.end(chosen) - choice.begin(chosen));
    u = std::min(u, 0x1.fffffffffffffp-1);
    node = child;
    choice = weigh(nodes_[node], from);
  }
}

float LightTree::pdf(const Query& from, const Choice& first, uint32_t light) const {
  if (light >= light_places_.size() || light_places_[light].node == kNoIndex) {
    return 0.0f;
  }
  float pdf = 1.0f;
  for (Place at = light_places_[light]; at.node != kNoIndex; at = node_places_[at.node]) {
    const Choice choice = at.node == 0 ? first : weigh(nodes_[at.node], from);
    const float share = share_of(choice, at.lane);
    if (!(share > 0.0f)) {
      return 0.0f;
    }
    pdf *= share / choice.sum();
  }
  return pdf;
}

}  // namespace vernier
