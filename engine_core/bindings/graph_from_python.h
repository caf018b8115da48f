// Python's engine_core.description.Graph as the core's.
#pragma once

#include <nanobind/nanobind.h>

#include "scene/description.h"

namespace vernier {

// Throws nb::cast_error or std::invalid_argument, naming the node, where a field is of the wrong
// type.
GraphDesc graph_from_python(nanobind::handle graph);

}  // namespace vernier
