// The choice between the lights that are far away and the tree of all others.
#pragma once

#include <algorithm>
#include <cmath>

#include "lights/light_table.h"
#include "math/vec.h"

namespace vernier {

// Share of the choice between the tree and the distant lights that is even: their irradiances know
// nothing of walls, and a lamp in a room must not starve beside the sun outside.
inline constexpr float kEvenShare = 0.2f;

// Rough irradiance from a distant light, on the scale of the tree's.
inline float distant_importance(const LightTable& table, size_t i, const Receiver& from) {
  const uint32_t light = table.distant[i];
  const float irradiance = table.distant_irradiance[i];
  if (table.is_environment(light)) {
    return irradiance;
  }
  const Lamp& lamp = table.lamp(light);
  const float cos_ns = -dot(lamp.axis, from.ns);
  if (from.transmits) {
    return irradiance * std::max(std::abs(cos_ns), kImportanceCosineFloor);
  }
  const float cos_ng = -dot(lamp.axis, from.ng);
  // The sine of the sun's half angle: how far below the horizon its centre may be.
  const float sine = safe_sqrt(lamp.one_minus_cos_sun * (2.0f - lamp.one_minus_cos_sun)) + gamma(8);
  return cos_ng > -sine ? irradiance * std::max(cos_ns, kImportanceCosineFloor) : 0.0f;
}

// Of the irradiance E that other directions find as well, this part counts where all other lights'
// is as strong, and in proportion to E over theirs. With a part q of the samples its variance, of
// what hides the sky and about E^2 / 4, falls by (1 + q^3) / (1 + q^2)^2 (power heuristic), while
// that of the others, S^2 / (1 - q) - S^2 where nothing hides them, rises. The sum is least at q =
// 0 unless S is below about 0.4 E, and with q of a half or more from there on: q here is a half
// where S^2 = 0.15 E^2.
inline constexpr float kShareOfFound = 0.15f;

// The alternatives of the first choice: distant lights in their order, then the tree.
class FirstChoice {
 public:
  FirstChoice(const LightTable& table, const Receiver& from)
      : table_(table),
        from_(from),
        query_(from),
        in_tree_(table.tree.choose_first(query_)),
        complemented_(table.has_environment && table.environment.leaves_dim_to(from)) {
    tree_ = in_tree_.sum();
    add(tree_);
    const size_t others = table.distant.size() - (complemented_ ? 1 : 0);  // the world comes last
    for (size_t i = 0; i < others; ++i) {
      add(distant_importance(table, i, from));
    }
    if (complemented_) {
      add_complemented(table.distant_irradiance.back());
    }
  }
  bool any() const { return sum_ > 0.0f; }
  bool has_tree() const { return tree_ > 0.0f; }
  // Among the lights of the tree.
  uint32_t sample_tree(double u, float& pdf) const {
    return table_.tree.sample(query_, in_tree_, u, pdf);
  }
  float pdf_tree(uint32_t light) const { return table_.tree.pdf(query_, in_tree_, light); }
  float probability_of_tree() const { return probability(tree_); }
  // Of distant light number i.
  float probability_of(size_t i) const {
    if (!complemented_ || !table_.is_environment(table_.distant[i])) {
      return probability(distant_importance(table_, i, from_));
    }
    if (!(environment_ > 0.0f)) {
      return 0.0f;
    }
    return may_starve_ ? probability(environment_) : environment_ / sum_ * (1.0f - even_share());
  }

 private:
  void add(float importance) {
    sum_ += importance;
    alternatives_ += importance > 0.0f ? 1 : 0;
  }
  void add_complemented(float irradiance) {
    if (table_.environment.leaves_all_to(from_)) {
      return;
    }
    const float peaks = irradiance * table_.environment.share_of_peaks();
    const float found = irradiance - peaks, others = sum_ + peaks;
    environment_ =
        peaks + (others > 0.0f ? found * std::min(kShareOfFound * found / others, 1.0f) : found);
    sum_ += environment_;
    // A sun in a sky is hardly found by other directions; the sky is.
    may_starve_ = peaks > found;
    alternatives_ += may_starve_ ? 1 : 0;
  }
  float even_share() const { return alternatives_ > 1 ? kEvenShare : 0.0f; }
  float probability(float importance) const {
    return importance > 0.0f
               ? lerp(importance / sum_, 1.0f / static_cast<float>(alternatives_), even_share())
               : 0.0f;
  }

  const LightTable& table_;
  const Receiver& from_;
  const LightTree::Query query_;
  const LightTree::Choice in_tree_;
  float sum_ = 0;
  uint32_t alternatives_ = 0;
  float tree_ = 0;
  bool complemented_;        // by directions that find the world
  float environment_ = 0;    // where it is
  bool may_starve_ = false;  // the world, without even choices
};

}  // namespace vernier
