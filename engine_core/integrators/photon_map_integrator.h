// Photon mapping with two maps.
#pragma once

#include "integrators/integrator.h"

namespace vernier {

Kernel photon_map_kernel(const Settings& settings, const Requirements& requirements,
                         PassSet passes);

}  // namespace vernier
