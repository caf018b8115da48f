// The world as a light.
#pragma once

#include <functional>
#include <vector>

#include "lights/light_sample.h"
#include "math/distribution.h"
#include "math/octahedral.h"
#include "math/warp.h"

namespace vernier {

// Which directions of the world are sampled. A world of one radiance is sampled uniformly, in the
// upper hemisphere by the cosine where the receiver does not transmit; any other by a map of its
// radiance over the equal-area octahedron, which has no poles to distort. For receivers that are
// complemented by other directions, the map is of what exceeds the mean: what is dimmer is left to
// those, and no sample is lost to it that the bright parts need (Karlik et al. 2019, "MIS
// Compensation: Optimizing Sampling Techniques in Multiple Importance Sampling", section 4).
class EnvironmentMap {
 public:
  // A uniform world.
  EnvironmentMap() = default;
  explicit EnvironmentMap(Color radiance) : mean_(average(abs(radiance))) {}
  // `resolution` cells along each side of the octahedral square, each the mean of `points` x
  // `points` of the radiance. `even`: rays of all kinds see the same.
  EnvironmentMap(int resolution, int points, bool even,
                 const std::function<Color(Vec3f)>& radiance);

  // Mean over all directions of the average of RGB.
  float mean_radiance() const { return mean_; }
  // Whether what is dim is left to the receiver's other directions: only where those find what
  // light sampling finds.
  bool leaves_dim_to(const Receiver& from) const { return even_ && from.complemented; }
  // Whether all of it is: a world of one radiance, none of which is worth a sample where the
  // receiver scatters to few directions.
  bool leaves_all_to(const Receiver& from) const {
    return uniform_ && leaves_dim_to(from) && from.narrow;
  }
  bool is_uniform() const { return uniform_; }
  // The part of it that exceeds the mean, which is what is then sampled.
  float share_of_peaks() const { return share_of_peaks_; }

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
    return sample_map(map_for(from), u, pdf);
  }
  float pdf(const Receiver& from, Vec3f wi) const {
    if (uniform_) {
      return from.transmits ? kInvFourPi : cosine_hemisphere_pdf(dot(wi, from.ns));
    }
    return pdf_map(map_for(from), wi);
  }

  // Without a receiver: the directions from which light comes, for light tracing.
  Vec3f sample_direction(Vec2f u, float& pdf) const;
  float pdf_direction(Vec3f wi) const;

 private:
  const PiecewiseConstant2D& map_for(const Receiver& from) const {
    return share_of_peaks_ > 0.0f && leaves_dim_to(from) ? peaks_ : map_;
  }
  void keep_peaks(std::vector<float>& cells, int resolution);  // changes the cells
  static Vec3f sample_map(const PiecewiseConstant2D& map, Vec2f u, float& pdf);
  static float pdf_map(const PiecewiseConstant2D& map, Vec3f wi);

  bool uniform_ = true, even_ = true;
  float mean_ = 0, share_of_peaks_ = 0;
  PiecewiseConstant2D map_, peaks_;
};

}  // namespace vernier
