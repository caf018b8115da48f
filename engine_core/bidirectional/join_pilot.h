// A pilot that learns which light vertices are worth joining to paths from the camera.
#pragma once

#include "bidirectional/plan.h"

namespace vernier {

// Learns the plan's joins with some `samples` samples, by paths as its guide starts them, and has
// them shared where it pays or the settings say so.
void learn_joins(const RenderContext& context, uint64_t seed, uint32_t samples,
                 BidirectionalPlan& plan, RenderStats& stats);

}  // namespace vernier
