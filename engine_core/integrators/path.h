// The path tracer.
#pragma once

#include "integrators/integrator.h"

namespace vernier {

// Unidirectional path tracing (Kajiya 1986) with next-event estimation, BSDF sampling, multiple
// importance sampling (Veach and Guibas 1995) and Russian roulette. The setting `direct_light`
// chooses among estimators with the same expectation.
RenderTile path_kernel(const Settings& settings, const Requirements& requirements, PassSet passes);

}  // namespace vernier
