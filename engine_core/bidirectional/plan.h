// What bidirectional methods learn of a scene before its first batch.
#pragma once

#include <algorithm>

#include "integrators/integrator.h"
#include "lights/emission_guide.h"
#include "paths/join_guide.h"

namespace vernier {

// What is known of the scene beforehand. It changes what is spent on which paths, never the
// picture.
struct BidirectionalPlan : Plan {
  EmissionGuide guide;
  JoinGuide joins;
  // The part of the samples that have a light path of their own, in (0, 1]. The others are the
  // camera's alone.
  double own_paths = 1.0;
  // Contributions below the inverse of this are followed by chance only; infinite: all are
  // followed.
  float inverse_threshold = kInfinity;
  // Radius of a pixel as it covers the surfaces that the camera sees, the median of them, metres;
  // 0: it sees none.
  float footprint = 0.0f;

  // Whether a contribution, of which `weight` counts, is worth more work. What is small beside the
  // picture is let go by chance, and raised where it stays; u is uniform in [0,1). Nothing stays of
  // what float32 does not hold. Random numbers resolve no chances far below the least one.
  bool worthwhile(Color& c, double weight, float u) const {
    constexpr float kLeastChance = 1e-6f;
    const float most = max_component(c);
    if (!(most > 0.0f)) {
      return false;
    }
    const float p = std::max(most * static_cast<float>(weight) * inverse_threshold, kLeastChance);
    if (!(p < 1.0f)) {
      return true;
    }
    if (!(u < p)) {
      return false;
    }
    c *= 1.0f / p;
    return true;
  }
};

// From a pilot of some thousand samples.
std::unique_ptr<const Plan> make_bidirectional_plan(const RenderContext& context, uint64_t seed,
                                                    RenderStats& stats);

}  // namespace vernier
