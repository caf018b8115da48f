// Russian roulette: ends paths by chance, without bias (Arvo and Kirk 1990).
#pragma once

#include <algorithm>
#include <cstdint>

#include "render/settings.h"

namespace vernier {

class Roulette {
 public:
  explicit Roulette(const Settings& settings)
      : threshold_(static_cast<float>(settings.roulette_threshold)),
        start_(settings.roulette_start),
        long_path_(settings.max_bounces < 0 ? kLongPath : kNever),
        long_passage_(settings.transparent_bounces < 0 ? kLongPath : kNever) {}
  // The same with a roulette of its own.
  Roulette(const Settings& settings, float threshold, int start) : Roulette(settings) {
    threshold_ = threshold;
    start_ = start;
  }

  // The probability of going on after `bounces` bounces, at vertex number `vertex`, for a path that
  // carries `carried` of what it started with. One that goes on is raised by its inverse.
  //
  // The best chance of going on is in proportion to what is carried, and to the root of what is to
  // come over what it costs (Vorba and Krivanek 2016, "Adjoint-Driven Russian Roulette and
  // Splitting", of which only what the path itself knows is used here). A path that still goes on
  // after many bounces is in a closed place, where much would be spent on each that is let live; in
  // the open most end by themselves. So the threshold grows with the bounces, up to all.
  float survival(int bounces, uint32_t vertex, float carried) const {
    const float growth = std::max(0.5f * static_cast<float>(bounces), 1.0f);
    const float threshold = std::min(threshold_ * growth, std::max(threshold_, 1.0f));
    float p = bounces > start_ && carried < threshold ? carried / threshold : 1.0f;
    const auto scattered = static_cast<uint32_t>(bounces);
    if (scattered >= long_path_ || vertex - std::min(scattered, vertex) >= long_passage_) {
      p = std::min(p, kLongPathSurvival);
    }
    return p;
  }

 private:
  // Between surfaces that absorb nothing a path need never carry less, nor meet a light. Where no
  // limit ends it, it ends by chance from this many surfaces of a kind on, whatever it carries.
  // (Where one does, chance would only take light away: of what survives hundreds of such chances
  // nothing is left to be seen, and what would be is too bright to be seen once.)
  static constexpr uint32_t kLongPath = 1024, kNever = 0xffffffffu;
  static constexpr float kLongPathSurvival = 0.9f;

  float threshold_;
  int start_;
  uint32_t long_path_, long_passage_;  // surfaces that scatter, and that let pass
};

}  // namespace vernier
