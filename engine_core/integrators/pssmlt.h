// Metropolis light transport in the space of the random numbers: PSSMLT and MMLT.
#pragma once

#include "integrators/integrator.h"

namespace vernier {

// Chains of whole bidirectional samples (Kelemen et al. 2002).
Kernel pssmlt_kernel(const Settings& settings, const Requirements& requirements, PassSet passes);
// Chains of single techniques (Hachisuka et al. 2014).
Kernel mmlt_kernel(const Settings& settings, const Requirements& requirements, PassSet passes);

}  // namespace vernier
