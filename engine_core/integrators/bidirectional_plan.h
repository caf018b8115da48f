// What bidirectional methods learn of a scene before its first batch.
#pragma once

#include "integrators/integrator.h"
#include "lights/emission_guide.h"

namespace vernier {

// What is known of the scene beforehand. It changes what is spent on which paths, never the
// picture.
struct BidirectionalPlan : Plan {
  EmissionGuide guide;
  // Contributions below the inverse of this are followed by chance only; infinite: all are
  // followed.
  float inverse_threshold = kInfinity;
};

// From a pilot of some thousand samples.
std::unique_ptr<const Plan> make_bidirectional_plan(const RenderContext& context, uint64_t seed,
                                                    RenderStats& stats);

}  // namespace vernier
