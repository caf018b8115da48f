// The world as a light.
#pragma once

#include <functional>

#include "lights/light_sample.h"
#include "math/distribution.h"
#include "math/octahedral.h"
#include "math/warp.h"

namespace vernier {

// Which directions of the world are sampled. A world of one radiance is sampled uniformly, in the
// upper hemisphere by the cosine where the receiver does not transmit; any other by a map of its
// radiance over the equal-area octahedron, which has no poles to distort.
class EnvironmentMap {
 public:
  // A uniform world.
  EnvironmentMap() = default;
  explicit EnvironmentMap(Color radiance) : mean_(average(abs(radiance))) {}
  // `resolution` cells along each side of the octahedral square, each the mean of `points` x
  // `points` of the radiance.
  EnvironmentMap(int resolution, int points, const std::function<Color(Vec3f)>& radiance);

  // Mean over all directions of the average of RGB.
  float mean_radiance() const { return mean_; }

  Vec3f sample(const Receiver& from, Vec2f u, float& pdf) const {
    if (uniform_) {
      if (from.transmits) {
        pdf = kInvFourPi;
        return square_to_uniform_sphere(u);
      }
      const Vec3f local = square_to_cosine_hemisphere(u);
      pdf = cosine_hemisphere_pdf(local.z);
      return Frame(from.ns).to_world(local);
    }
    return sample_direction(u, pdf);
  }
  float pdf(const Receiver& from, Vec3f wi) const {
    if (uniform_) {
      return from.transmits ? kInvFourPi : cosine_hemisphere_pdf(dot(wi, from.ns));
    }
    return pdf_direction(wi);
  }

  // Without a receiver: the directions from which light comes, for light tracing.
  Vec3f sample_direction(Vec2f u, float& pdf) const;
  float pdf_direction(Vec3f wi) const;

 private:
  bool uniform_ = true;
  float mean_ = 0;
  PiecewiseConstant2D map_;
};

}  // namespace vernier
