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
        start_(settings.roulette_start) {}

  // The probability of going on after `bounces` bounces, at vertex number `vertex`, for a path that
  // carries `carried` of what it started with. One that goes on is raised by its inverse.
  float survival(int bounces, uint32_t vertex, float carried) const {
    float p = bounces > start_ && carried < threshold_ ? carried / threshold_ : 1.0f;
    if (vertex >= kLongPath) {
      p = std::min(p, kLongPathSurvival);
    }
    return p;
  }

 private:
  // Between surfaces that absorb nothing a path need never carry less, nor meet a light. From this
  // vertex on it ends by chance whatever it carries.
  static constexpr uint32_t kLongPath = 1024;
  static constexpr float kLongPathSurvival = 0.9f;

  float threshold_;
  int start_;
};

}  // namespace vernier
