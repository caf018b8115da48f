// Whitted's recursive ray tracer.
#pragma once

#include "integrators/integrator.h"

namespace vernier {

// Deterministic recursive ray tracing (Whitted 1980, "An Improved Illumination Model for Shaded
// Display"): at every surface the light of each lamp's middle by one shadow ray, and rays along
// perfect reflection and refraction down to the depth `whitted_depth`. There is no interreflection
// of rough surfaces and no softness of shadows: the classic baseline.
RenderTile whitted_kernel();

}  // namespace vernier
