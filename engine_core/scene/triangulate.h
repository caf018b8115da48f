// Polygons to triangles.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "math/vec.h"

namespace vernier {

// Triangles of one polygon as triples of positions within it (0 to n - 1), n - 2 of them, wound
// as the polygon. Concave polygons are cut by ears in the plane of their area vector. Degenerate
// ones (collinear, self-crossing) still give n - 2 triangles, in time proportional to n: where no
// ear is found for long, the rest is a fan about one corner.
void triangulate(std::span<const Vec3f> polygon, std::vector<std::array<uint32_t, 3>>& triangles);

}  // namespace vernier
