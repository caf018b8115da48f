// Stochastic progressive photon mapping.
#pragma once

#include "integrators/integrator.h"

namespace vernier {

Kernel sppm_kernel(const Settings& settings, const Requirements& requirements, PassSet passes);

}  // namespace vernier
