// The sky of Preetham, Shirley and Smits 1999, "A Practical Analytic Model for Daylight", with the
// scale and the clamping at the horizon of Cycles (scene/shader_nodes.cpp, kernel/svm/sky.h).
#pragma once

#include <array>

#include "math/vec.h"

namespace vernier {

class PreethamSky {
 public:
  // `sun` is a unit vector, z up; turbidity
  // as the authors define it, 2 to 6 for what they fitted.
  PreethamSky(Vec3f sun, float turbidity);

  // Radiance from a unit direction, linear Rec.709, not negative. The sun's disc is not part of it.
  Color radiance(Vec3f direction) const;

 private:
  struct Channel {
    float zenith;  // over the distribution's value there
    std::array<float, 5> perez;
    float operator()(float theta, float gamma) const;
  };

  Channel luminance_, x_, y_;
  Vec3f sun_;
};

}  // namespace vernier
