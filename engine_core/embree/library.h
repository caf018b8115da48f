// Opens the Embree library that the `embreex` wheel carries, isolated from any other Embree.
//
// Blender has its own Embree and TBB in the same process. The wheel's library is opened with
// RTLD_LOCAL (its symbols serve nobody else) and RTLD_DEEPBIND (its own symbols, TBB's included,
// win over those already loaded), and every function is called through this table alone.
#pragma once

#include <string>

#include "embree/api.h"

namespace vernier::embree {

struct Library {
#define VERNIER_DECLARE(name, result, parameters) result(*name) parameters = nullptr;
  VERNIER_EMBREE_FUNCTIONS(VERNIER_DECLARE)
#undef VERNIER_DECLARE
};

// Opens the library once for the process. Throws std::runtime_error naming the file and the reason
// when it cannot be opened, lacks a function, or is not Embree 4.
void load(const std::string& path);

// The loaded library. Throws std::runtime_error before load() succeeded.
const Library& library();

// Scenes compiled from now on cast their rays by these functions (see recorder.h).
void set_ray_functions(decltype(Library::rtcIntersect1) intersect,
                       decltype(Library::rtcOccluded1) occluded);

}  // namespace vernier::embree
