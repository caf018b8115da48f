#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <malloc.h>

#include <atomic>
#include <chrono>

#include "bindings/bind.h"
#include "bindings/description_from_python.h"
#include "scene/compile.h"

namespace nb = nanobind;

namespace vernier {
namespace {

// Shared ownership of an immutable scene. (nanobind holds no pointers to const.)
struct SceneHandle {
  std::shared_ptr<const Scene> scene;
  // The Python meshes and images that it was compiled from, by which a later compilation knows them
  // again; empty unless it was compiled interactively.
  std::vector<nb::object> sources;
};

nb::dict requirements(const SceneHandle& handle) {
  const Requirements& r = handle.scene->requirements;
  nb::dict d;
  d["triangles"] = r.triangles;
  d["instanced_triangles"] = r.instanced_triangles;
  d["instances"] = r.instances;
  d["lamps"] = r.lamps;
  d["emissive_triangles"] = r.emissive_triangles;
  d["constant_materials"] = r.constant_materials;
  d["program_materials"] = r.program_materials;
  d["programs"] = r.programs;
  d["transparent_shadows"] = r.transparent_shadows;
  d["environment"] = r.environment;
  d["textured_emission"] = r.textured_emission;
  d["depth_of_field"] = r.depth_of_field;
  d["singular_lobes"] = r.singular_lobes;
  d["caustics"] = r.caustics;
  d["transmission"] = r.transmission;
  d["instancing"] = r.instancing;
  d["light_tree"] = r.light_tree;
  d["hidden_from_rays"] = r.hidden_from_rays;
  d["uneven_visibility"] = r.uneven_visibility;
  d["things_in_lamps"] = r.things_in_lamps;
  d["path_dependent"] = r.path_dependent;
  d["transmits_by_side"] = r.transmits_by_side;
  return d;
}

// Asks `cancelled` at most every kPollInterval, whatever number of threads want to know and how
// often: each question waits for the interpreter's lock.
class CancelPoll {
 public:
  explicit CancelPoll(const nb::object& cancelled) : cancelled_(cancelled) {}

  bool operator()() {
    const int64_t now = std::chrono::steady_clock::now().time_since_epoch().count();
    int64_t next = next_;
    if (answer_ || now < next || !next_.compare_exchange_strong(next, now + kPollInterval)) {
      return answer_;
    }
    const nb::gil_scoped_acquire lock;
    answer_ = nb::cast<bool>(nb::bool_(cancelled_()));
    return answer_;
  }

 private:
  static constexpr int64_t kPollInterval =
      std::chrono::steady_clock::duration(std::chrono::milliseconds(20)).count();
  const nb::object& cancelled_;
  std::atomic<int64_t> next_{0};
  std::atomic<bool> answer_{false};
};

SceneHandle compile_scene(nb::handle description, int threads, bool keep_uv,
                          const nb::object& cancelled, bool consume, bool interactive,
                          const SceneHandle* previous) {
  BorrowedDescription borrowed = description_from_python(description, interactive);
  CompileOptions options;
  options.threads = threads;
  options.keep_uv = keep_uv;
  options.interactive = interactive;
  if (previous != nullptr) {
    options.previous = previous->scene;
  }
  CancelPoll poll(cancelled);
  if (!cancelled.is_none()) {
    options.cancelled = [&poll] { return poll(); };
  }
  if (consume) {
    options.large_parts_read = [&borrowed, description] {
      const nb::gil_scoped_acquire lock;
      borrowed.mesh_owners.clear();
      borrowed.image_owners.clear();
      description.attr("meshes").attr("clear")();
      description.attr("images").attr("clear")();
      malloc_trim(0);  // else what was freed stays with the process
    };
  }
  SceneHandle result;
  if (interactive) {
    for (const char* name : {"meshes", "images"}) {
      for (nb::handle source : description.attr(name)) {
        result.sources.push_back(nb::borrow(source));
      }
    }
  }
  const nb::gil_scoped_release release;
  result.scene = compile(borrowed.description, options);
  return result;
}

SceneHandle view_scene(const SceneHandle& handle, nb::handle camera, nb::handle film) {
  return {with_view(handle.scene, camera_from_python(camera), film_from_python(film)),
          handle.sources};
}

nb::dict compiled_parts(const SceneHandle& handle) {
  const CompiledParts& parts = handle.scene->compiled;
  nb::dict d;
  d["geometry"] = parts.geometry;
  d["lights"] = parts.lights;
  d["materials"] = parts.materials;
  d["images"] = parts.images;
  d["changed"] = parts.changed;
  return d;
}

}  // namespace

std::shared_ptr<const Scene> scene_of(nb::handle handle) {
  return nb::cast<const SceneHandle&>(handle).scene;
}

void bind_scene(nb::module_& m) {
  nb::class_<SceneHandle>(m, "Scene", "A compiled scene; immutable.")
      .def_prop_ro(
          "warnings", [](const SceneHandle& s) { return s.scene->warnings; },
          "What was replaced or left out, a sentence each.")
      .def_prop_ro("requirements", &requirements, "What the scene needs of the renderer.")
      .def_prop_ro("compiled", &compiled_parts,
                   "What was made for it, as opposed to shared with the scene before.")
      .def("with_view", &view_scene, nb::arg("camera"), nb::arg("film"),
           "The same scene through another (valid) camera onto another film; all else is shared.")
      .def_prop_ro(
          "width",
          [](const SceneHandle& s) { return s.scene->film.crop[2] - s.scene->film.crop[0]; })
      .def_prop_ro("height", [](const SceneHandle& s) {
        return s.scene->film.crop[3] - s.scene->film.crop[1];
      });
  m.def("compile", &compile_scene, nb::arg("description"), nb::arg("threads"), nb::arg("keep_uv"),
        nb::arg("cancelled").none(), nb::arg("consume"), nb::arg("interactive"),
        nb::arg("previous").none(), "Compiles a validated description.");
}

}  // namespace vernier
