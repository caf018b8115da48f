// Probes of the mutations of whole paths: chains of one mutation alone, and the densities of paths.
#include <nanobind/stl/map.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/variant.h>
#include <nanobind/stl/vector.h>

#include <cmath>
#include <stdexcept>

#include "bindings/bind.h"
#include "metropolis/path_explorer.h"
#include "paths/technique_pdfs.h"

namespace nb = nanobind;

namespace vernier {
namespace {

// What a chain needs of a render.
struct Ground {
  std::shared_ptr<const Scene> scene;
  Settings settings;
  PixelFilter2d filter;
  std::atomic<bool> cancelled{false};
  RenderStats stats;
  std::unique_ptr<const Plan> plan;

  Ground(nb::handle handle, const std::map<std::string, SettingValue>& values)
      : scene(scene_of(handle)),
        settings(make_settings(values)),
        filter(scene->film.filter, scene->film.filter_width) {
    plan = make_metropolis_plan(context(), 1, stats);
  }
  RenderContext context() const { return {*scene, settings, filter, cancelled, plan.get()}; }
};

double mutate(const std::string& name, PathSpace& space, const PathState& from, PathState& to) {
  if (name == "bidirectional") {
    return mutate_bidirectionally(space, from, to);
  }
  if (name == "camera") {
    return perturb_from_camera(space, from, to);
  }
  if (name == "light") {
    return perturb_from_light(space, from, to);
  }
  if (name == "lens") {
    return replace_lens_subpath(space, space.film.raster(space.random_2d()), from, to);
  }
  if (name == "new") {
    return propose_new_path(space, from, to);
  }
  throw std::invalid_argument("there is no mutation named " + name);
}

// The chain's first path.
void begin(const RenderContext& context, RenderStats& stats, uint64_t seed,
           MarkovChain<PathState>& chain) {
  PathExplorer explorer(context, stats);
  Pcg32 rng(seed);
  for (uint32_t i = 0; chain.current.v.empty(); ++i) {
    chain.current.clear();
    PrimaryEvaluator evaluator(context, stats, true);
    Contribution sample;
    const SobolSampler source(0, 0, i, 16, seed);
    evaluator.sample(source, sample);
    if (sample.target > 0.0) {
      explorer.start(source, rng, chain);
    }
  }
}

// A chain of `steps` mutations, of which every second is the one that is named and the others are
// new paths. Visits by number of surfaces (up to `longest`) and by cells of the frame, `side` to a
// side; and how often the mutation was accepted.
nb::dict mutation_chain(nb::handle handle, const std::map<std::string, SettingValue>& values,
                        const std::string& name, uint64_t steps, uint64_t seed, int side,
                        int longest) {
  const Ground ground(handle, values);
  RenderStats stats;
  const RenderContext context = ground.context();
  MarkovChain<PathState> chain;
  begin(context, stats, seed, chain);
  PathSpace space(context, stats);
  space.seed(Pcg32(hash64(seed)));
  std::vector<double> visits(static_cast<size_t>(side * side * longest));
  const FilmDesc& film = context.scene.film;
  const auto record = [&](const PathState& path, double count) {
    const auto cell = [&](float at, int size) {
      return std::clamp(static_cast<int>(at / static_cast<float>(size) * static_cast<float>(side)),
                        0, side - 1);
    };
    const int k = std::min(static_cast<int>(path.v.size()), longest) - 1;
    visits[static_cast<size_t>((k * side + cell(path.raster.y, film.height)) * side +
                               cell(path.raster.x, film.width))] += count;
  };
  uint64_t tried = 0, accepted = 0;
  for (uint64_t i = 0; i < steps; ++i) {
    const bool own = i % 2 == 0;
    double ratio = mutate(own ? name : "new", space, chain.current, chain.proposed);
    ratio = std::isfinite(ratio) ? std::exp(std::min(ratio, 700.0)) : 0.0;
    const bool moved = metropolis_step(chain, ratio, space.random(), record);
    tried += own ? 1 : 0;
    accepted += own && moved ? 1 : 0;
  }
  end_chain(chain, record);
  nb::dict result;
  result["visits"] = visits;
  result["accepted"] = static_cast<double>(accepted) / static_cast<double>(tried);
  return result;
}

// The path as technique_pdfs.h has it.
Path plain_path(const PathSpace& space, const PathState& state) {
  Path path;
  path.camera.direction = state.v[0].point.wo;
  path.camera.pdf_across = state.pdf_across / space.film.share();
  for (const ChainVertex& v : state.v) {
    PathSurface s;
    s.p = v.point.p;
    s.ng = v.point.ng;
    s.pdf_to_light = v.pdf_to_light;
    s.pdf_to_camera = v.pdf_to_camera;
    s.singular = v.event != 0;
    path.surfaces.push_back(s);
  }
  path.light.direction = state.v.back().to_light;
  path.light.pdf_sampled = state.end.pdf_sampled;
  path.light.pdf_emitted = state.end.pdf_emitted;
  path.light.hittable = state.end.pdf_met > 0.0;
  return path;
}

// Paths that mutations visit. For each: by surface the logarithms of both walks' area densities (as
// technique_pdfs.h has them) and of refraction, and whether it is singular; the densities of its
// end; and by (a, b) the logarithm of the density with which the rest is grown between them.
nb::list grown_densities(nb::handle handle, const std::map<std::string, SettingValue>& values,
                         uint64_t count, uint64_t seed) {
  const Ground ground(handle, values);
  RenderStats stats;
  const RenderContext context = ground.context();
  MarkovChain<PathState> chain;
  begin(context, stats, seed, chain);
  PathSpace space(context, stats);
  space.seed(Pcg32(hash64(seed)));
  nb::list result;
  const auto record = [](const PathState&, double) {};
  for (uint64_t found = 0; found < count;) {
    double ratio =
        mutate(found % 2 == 0 ? "new" : "bidirectional", space, chain.current, chain.proposed);
    ratio = std::isfinite(ratio) ? std::exp(std::min(ratio, 700.0)) : 0.0;
    if (!metropolis_step(chain, ratio, space.random(), record)) {
      continue;
    }
    ++found;
    const PathState& state = chain.current;
    const SurfacePdfs pdfs = surface_pdfs(plain_path(space, state));
    nb::dict row;
    row["log_camera"] = pdfs.log_camera;
    row["log_light"] = pdfs.log_light;
    std::vector<double> refraction, to_light;
    std::vector<int> singular;
    for (const ChainVertex& v : state.v) {
      refraction.push_back(v.log_refraction);
      to_light.push_back(v.pdf_to_light);
      singular.push_back(v.event != 0 ? 1 : 0);
    }
    row["log_refraction"] = refraction;
    row["pdf_to_light"] = to_light;
    row["singular"] = singular;
    row["pdf_sampled"] = state.end.pdf_sampled;
    row["pdf_met"] = state.end.pdf_met;
    nb::dict grown;
    for (size_t a = 0; a <= state.v.size(); ++a) {
      for (size_t b = 0; a + b <= state.v.size(); ++b) {
        grown[nb::make_tuple(a, b)] = space.log_grown(state, a, b);
      }
    }
    row["grown"] = grown;
    result.append(row);
  }
  return result;
}

}  // namespace

void bind_mutation_probes(nb::module_& m) {
  m.def("mutation_chain", &mutation_chain, nb::arg("scene"), nb::arg("settings"), nb::arg("name"),
        nb::arg("steps"), nb::arg("seed"), nb::arg("side"), nb::arg("longest"));
  m.def("grown_densities", &grown_densities, nb::arg("scene"), nb::arg("settings"),
        nb::arg("count"), nb::arg("seed"));
}

}  // namespace vernier
