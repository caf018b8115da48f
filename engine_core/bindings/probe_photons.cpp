// A probe of photons: what they leave, and where their power goes.
#include <nanobind/ndarray.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/variant.h>

#include <bit>

#include "bindings/bind.h"
#include "bindings/probe_render.h"
#include "bindings/table.h"
#include "math/float_environment.h"
#include "math/parallel.h"
#include "photons/photon_pass.h"
#include "photons/radius.h"

namespace nb = nanobind;

namespace vernier {
namespace {

constexpr uint8_t kAllKinds = kind_bit(PhotonKind::kDirect) | kind_bit(PhotonKind::kCaustic) |
                              kind_bit(PhotonKind::kIndirect);

// Traces `paths` photons by the lights' power. A dictionary of the tally's sums, and of rows of
// (position in the world, power, kind, bounces) of all photons that lie on surfaces.
nb::dict trace_photons(nb::handle handle, const std::map<std::string, SettingValue>& values,
                       uint32_t paths, uint64_t seed) {
  ProbeRender render(handle, values);
  const Scene* scene = render.scene.get();
  const RenderContext context = render.context();
  RenderStats& stats = render.stats;
  PhotonChunk chunk;
  for (uint32_t i = 0; i < paths; ++i) {
    trace_photon(context, scene->lights->guide_by_power(), seed, i,
                 static_cast<int>(std::bit_width(paths - 1u)), kAllKinds, chunk, stats,
                 [](const EmissionSample&, const PhotonVisitor&) {});
  }
  const Table table(chunk.photons.size(), 8);
  for (size_t i = 0; i < table.rows(); ++i) {
    const Photon& photon = chunk.photons[i];
    float* out = table.row(i);
    write(scene->to_world(chunk.positions[i]), out);
    write(photon.power, out + 3);
    out[6] = static_cast<float>(photon.kind);
    out[7] = static_cast<float>(photon.bounces);
  }
  nb::dict result;
  result["paths"] = chunk.tally.paths;
  result["emitted"] = chunk.tally.emitted;
  result["absorbed"] = chunk.tally.absorbed;
  result["escaped"] = chunk.tally.escaped;
  result["arrived"] = chunk.tally.arrived;
  result["total_power"] = scene->lights->total_power();
  result["photons"] = table.release();
  result["non_finite"] = stats.non_finite;
  return result;
}

// Makes a map of all photons of `paths` paths by the lights' power, on the settings' threads. A
// dictionary of its number of photons, of paths and of bytes.
nb::dict build_photon_map(nb::handle handle, const std::map<std::string, SettingValue>& values,
                          uint64_t paths, uint64_t seed) {
  const ProbeRender render(handle, values);
  const RenderContext context = render.context();
  PhotonOrder order;
  order.guide = &render.scene->lights->guide_by_power();
  order.kinds = kAllKinds;
  order.paths = order.most_paths = paths;
  PhotonPass pass({order}, Batch{.seed = seed});
  for (int stage = 0; stage < pass.stages(); ++stage) {
    std::vector<RenderStats> stats(pass.jobs(stage));
    parallel_for(stats.size(), render.settings.threads, [&](size_t job) {
      const FlushDenormals flush;
      pass.run(stage, job, context, stats[job]);
    });
  }
  nb::dict result;
  result["photons"] = pass.map(0).size();
  result["paths"] = pass.map(0).tally().paths;
  result["memory"] = pass.map(0).memory();
  return result;
}

}  // namespace

void bind_photons_probes(nb::module_& m) {
  m.def("trace_photons", &trace_photons, nb::arg("scene"), nb::arg("settings"), nb::arg("paths"),
        nb::arg("seed"));
  m.def("build_photon_map", &build_photon_map, nb::arg("scene"), nb::arg("settings"),
        nb::arg("paths"), nb::arg("seed"));
  m.def("progressive_radius", &progressive_radius);
}

}  // namespace vernier
