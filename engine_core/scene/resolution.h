// Whether 32-bit coordinates still tell the shapes of things that lie far away.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "scene/description.h"
#include "scene/geometry.h"

namespace vernier {

// A sentence for the mesh whose own vertices are the coarsest, and one for the object that is by
// its place in the scene, where neighbouring coordinates are more than 1/500 of its size apart.
// `meshes`: the bounds of the meshes, object space. `origin`: of render space, world space.
std::vector<std::string> describe_unresolved(const SceneDescription& desc,
                                             std::span<const Box> meshes,
                                             const std::array<double, 3>& origin);

}  // namespace vernier
