// A probe of photons: what they leave, and where their power goes.
#include <nanobind/ndarray.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/variant.h>

#include <bit>

#include "bindings/bind.h"
#include "bindings/table.h"
#include "photons/photon_walk.h"
#include "photons/radius.h"

namespace nb = nanobind;

namespace vernier {
namespace {

// Traces `paths` photons by the lights' power. A dictionary of the tally's sums, and of rows of
// (position in the world, power, kind, bounces) of all photons that lie on surfaces.
nb::dict trace_photons(nb::handle handle, const std::map<std::string, SettingValue>& values,
                       uint32_t paths, uint64_t seed) {
  const auto scene = scene_of(handle);
  const Settings settings = make_settings(values);
  const PixelFilter2d filter(scene->film.filter, scene->film.filter_width);
  const std::atomic<bool> cancelled{false};
  const RenderContext context{*scene, settings, filter, cancelled};
  RenderStats stats;
  PhotonChunk chunk;
  constexpr uint8_t kAll = kind_bit(PhotonKind::kDirect) | kind_bit(PhotonKind::kCaustic) |
                           kind_bit(PhotonKind::kIndirect);
  for (uint32_t i = 0; i < paths; ++i) {
    trace_photon(context, scene->lights->guide_by_power(), seed, i,
                 static_cast<int>(std::bit_width(paths - 1u)), kAll, chunk, stats,
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

}  // namespace

void bind_photons_probes(nb::module_& m) {
  m.def("trace_photons", &trace_photons, nb::arg("scene"), nb::arg("settings"), nb::arg("paths"),
        nb::arg("seed"));
  m.def("progressive_radius", &progressive_radius);
}

}  // namespace vernier
