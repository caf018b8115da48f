// What a point of a chain's space gives to the picture: a list of splats, and their luminance.
#pragma once

#include <vector>

#include "math/vec.h"

namespace vernier {

struct Splat {
  Vec2f raster;      // pixels of the full frame, as Camera has them
  Color color;       // a pixel's value where all of it is its own
  int s = 0, t = 0;  // the technique that found it
  double target = 0;
};

// The target of a chain is the sum of its splats' luminances (Veach and Guibas 1997, section 5.1),
// by what light is worth where it falls.
struct Contribution {
  std::vector<Splat> splats;
  double target = 0;
  // The target of this point as independent samples find it: what decides how much of it is theirs.
  // Infinite: nothing.
  double independent_target = 0;

  void clear() {
    splats.clear();
    target = independent_target = 0;
  }
  // The number of the splat that u in [0,1) chooses, in proportion to their targets. There is one
  // where the target is not 0.
  size_t choose(float u) const {
    double left = static_cast<double>(u) * target;
    size_t chosen = 0;
    for (size_t i = 0; i < splats.size(); ++i) {
      if (splats[i].target > 0.0) {
        chosen = i;
        if ((left -= splats[i].target) < 0.0) {
          break;
        }
      }
    }
    return chosen;
  }
  // `worth` 0: chains do not explore it.
  void add(Vec2f raster, Color color, float worth, int s, int t) {
    const float y = luminance(color);
    if (y > 0.0f) {
      const double value = static_cast<double>(y * worth);
      splats.push_back({raster, color, s, t, value});
      target += value;
    }
  }
};

}  // namespace vernier
