// One mesh of the description to triangles.
#pragma once

#include <span>
#include <string>

#include "scene/description.h"
#include "scene/scene.h"

namespace vernier {

// Triangulates and keeps what is asked for.
// `attribute_names`: the attributes that materials read; others are dropped.
// `to_render`: null for a mesh that stays in object space (instanced), else what its vertices are
// moved by, in float64 with one rounding at the end: 12 entries in rows.
Mesh compile_mesh(const MeshDesc& desc, std::span<const std::string> attribute_names,
                  const double* to_render, int threads);

}  // namespace vernier
