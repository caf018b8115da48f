// Python's SceneDescription as the core's: views into its arrays, nothing copied that is large.
#pragma once

#include <nanobind/nanobind.h>

#include <vector>

#include "scene/description.h"

namespace vernier {

// The description, and the arrays that it refers to, kept alive together.
struct BorrowedDescription {
  SceneDescription description;
  std::vector<nanobind::object> mesh_owners, image_owners, owners;
};

// Throws nb::python_error or nb::cast_error where a field is missing or of the wrong type:
// engine_core.validation has been run before and says so better.
// `with_identities`: meshes and images have the address of their Python object as their identity;
// whoever compares it later keeps that object alive.
BorrowedDescription description_from_python(nanobind::handle description, bool with_identities);

// Parts of it by themselves; throw alike.
CameraDesc camera_from_python(nanobind::handle camera);
FilmDesc film_from_python(nanobind::handle film);

}  // namespace vernier
