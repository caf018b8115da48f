// Bidirectional path tracing and light tracing.
#pragma once

#include "integrators/integrator.h"

namespace vernier {

// Paths joined from a sub-path that starts at the camera and one that starts at a light, in every
// way, each weighed against all others that make the same path (Lafortune and Willems 1993; Veach
// and Guibas 1994 and 1995). Light tracing is the part of it that the lights' sub-paths do alone.
Kernel bidirectional_kernel(const Settings& settings, const Requirements& requirements,
                            PassSet passes);

}  // namespace vernier
