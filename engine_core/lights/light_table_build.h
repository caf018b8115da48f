// How a light table comes from a scene.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "lights/light_table.h"
#include "scene/description.h"

namespace vernier {

std::unique_ptr<const LightTable> build_light_table(
    const Scene& scene, std::span<const LightDesc> lamps,
    std::vector<std::unique_ptr<Material>> lamp_shaders, std::vector<std::string>& warnings,
    int environment_resolution);

// Radiance of the world (which must exist) against the unit direction d.
Color environment_radiance(const Scene& scene, Vec3f d, uint32_t flags, const PathDepth& depth);

}  // namespace vernier
