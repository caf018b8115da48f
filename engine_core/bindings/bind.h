// What each binding file adds to the module.
#pragma once

#include <nanobind/nanobind.h>

#include <memory>

namespace vernier {

class Scene;

// The scene that a Python `Scene` holds.
std::shared_ptr<const Scene> scene_of(nanobind::handle handle);

void bind_tables(nanobind::module_& m);
void bind_scene(nanobind::module_& m);
void bind_session(nanobind::module_& m);
void bind_bsdf_probes(nanobind::module_& m);
void bind_nodes_probes(nanobind::module_& m);
void bind_lights_probes(nanobind::module_& m);
void bind_core_probes(nanobind::module_& m);
void bind_accuracy_probes(nanobind::module_& m);
void bind_paths_probes(nanobind::module_& m);
void bind_spatial_probes(nanobind::module_& m);
void bind_photons_probes(nanobind::module_& m);
void bind_coverage_probes(nanobind::module_& m);
void bind_cut_short_probes(nanobind::module_& m);
void bind_metropolis_probes(nanobind::module_& m);
void bind_mutation_probes(nanobind::module_& m);

}  // namespace vernier
