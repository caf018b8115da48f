// Things within the spheres of lamps.
#pragma once

#include <span>

#include "scene/description.h"

namespace vernier {

class Scene;

// Whether something lies within a point or spot lamp that shines as a hard sphere. Such a sphere
// emits outward only, but lights what is within it all round, as Cycles does: that light reaches
// paths from the camera alone. Looks along some directions of some lamps, and so may overlook what
// is small.
bool lamps_hold_things(const Scene& scene, std::span<const LightDesc> lamps);

}  // namespace vernier
