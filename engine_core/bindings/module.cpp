// The extension module: scenes, sessions and the tables that the add-on reads. No logic.
#include <nanobind/nanobind.h>

#include "bindings/bind.h"
#include "math/memory_message.h"

namespace {

void translate_memory(const std::exception_ptr& error, void* /*payload*/) {
  try {
    std::rethrow_exception(error);
  } catch (const std::bad_alloc& e) {
    PyErr_SetString(PyExc_MemoryError, vernier::message_of(e));
  } catch (const std::length_error& e) {
    PyErr_SetString(PyExc_MemoryError, vernier::message_of(e));
  }
}

}  // namespace

#define VERNIER_NB_MODULE(name, variable) NB_MODULE(name, variable)

VERNIER_NB_MODULE(VERNIER_MODULE, m) {
  m.doc() = "The rendering core of Vernier, compiled for one instruction set.";
  nanobind::register_exception_translator(translate_memory);
  vernier::bind_tables(m);
  vernier::bind_scene(m);
  vernier::bind_session(m);
  nanobind::module_ probe = m.def_submodule(
      "probe", "Vectorised access to single samplers and functions, for statistical tests.");
  vernier::bind_bsdf_probes(probe);
  vernier::bind_nodes_probes(probe);
  vernier::bind_lights_probes(probe);
  vernier::bind_core_probes(probe);
  vernier::bind_accuracy_probes(probe);
  vernier::bind_paths_probes(probe);
  vernier::bind_metropolis_probes(probe);
  vernier::bind_mutation_probes(probe);
  vernier::bind_spatial_probes(probe);
  vernier::bind_photons_probes(probe);
  vernier::bind_coverage_probes(probe);
  vernier::bind_cut_short_probes(probe);
}
