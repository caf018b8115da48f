// Metropolis light transport on whole paths (Veach and Guibas 1997).
#pragma once

#include "integrators/integrator.h"

namespace vernier {

Kernel mlt_kernel(const Settings& settings, const Requirements& requirements, PassSet passes);

}  // namespace vernier
