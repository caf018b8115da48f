// Probes of the mutations of whole paths: chains of one mutation alone, and the densities of paths.
#include <nanobind/stl/array.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/variant.h>
#include <nanobind/stl/vector.h>

#include <cmath>
#include <stdexcept>

#include "bindings/bind.h"
#include "bindings/probe_render.h"
#include "bindings/table.h"
#include "metropolis/path_explorer.h"
#include "metropolis/seed_pool.h"
#include "paths/technique_pdfs.h"

namespace nb = nanobind;

namespace vernier {
namespace {

// What a chain needs of a render.
struct Ground : ProbeRender {
  const std::unique_ptr<const Plan> plan;

  Ground(nb::handle handle, const std::map<std::string, SettingValue>& values)
      : ProbeRender(handle, values), plan(make_metropolis_plan(ProbeRender::context(), 1, stats)) {}
  RenderContext context() const { return ProbeRender::context(plan.get()); }
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

// A chain of mutations of whole paths, from its first path on.
struct MutationChain {
  const Ground ground;
  RenderStats stats;
  const RenderContext context;
  PathSpace space;
  MarkovChain<PathState> chain;

  MutationChain(nb::handle handle, const std::map<std::string, SettingValue>& values, uint64_t seed)
      : ground(handle, values), context(ground.context()), space(context, stats) {
    PathExplorer explorer(context, stats);
    PrimaryEvaluator evaluator(context, stats, true);
    Pcg32 rng(seed);
    Contribution sample;
    for (uint32_t i = 0; chain.current.v.empty(); ++i) {
      chain.current.clear();
      const SobolSampler source(0, 0, i, 16, seed);
      evaluator.sample(source, sample);
      if (sample.target > 0.0) {
        explorer.start(source, rng, chain);
      }
    }
    space.seed(Pcg32(hash64(seed)));
  }

  // One step of the mutation of this name; true: it was accepted.
  template <class Record>
  bool step(const std::string& name, const Record& record) {
    const double log_ratio = mutate(name, space, chain.current, chain.proposed);
    const double ratio = std::isfinite(log_ratio) ? std::exp(std::min(log_ratio, 700.0)) : 0.0;
    return metropolis_step(chain, ratio, space.random(), record);
  }
};

// A chain of `steps` mutations, of which every second is the one that is named and the others are
// new paths. Visits by number of surfaces (up to `longest`) and by cells of the frame, `side` to a
// side; and how often the mutation was accepted.
nb::dict mutation_chain(nb::handle handle, const std::map<std::string, SettingValue>& values,
                        const std::string& name, uint64_t steps, uint64_t seed, int side,
                        int longest) {
  MutationChain chain(handle, values, seed);
  std::vector<double> visits(static_cast<size_t>(side * side * longest));
  const FilmDesc& film = chain.context.scene.film;
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
    const bool moved = chain.step(own ? name : "new", record);
    tried += own ? 1 : 0;
    accepted += own && moved ? 1 : 0;
  }
  end_chain(chain.chain, record);
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
// technique_pdfs.h has them), of refraction, of passing what is before the surface (and, last, the
// light) and of either walk's not passing the surface, and whether it is singular; the densities of
// its end; and by (a, b) the logarithm of the density with which the rest is grown between them.
nb::list grown_densities(nb::handle handle, const std::map<std::string, SettingValue>& values,
                         uint64_t count, uint64_t seed) {
  MutationChain chain(handle, values, seed);
  nb::list result;
  const auto record = [](const PathState&, double) {};
  for (uint64_t found = 0; found < count;) {
    if (!chain.step(found % 2 == 0 ? "new" : "bidirectional", record)) {
      continue;
    }
    ++found;
    const PathState& state = chain.chain.current;
    const SurfacePdfs pdfs = surface_pdfs(plain_path(chain.space, state));
    nb::dict row;
    row["log_camera"] = pdfs.log_camera;
    row["log_light"] = pdfs.log_light;
    std::vector<double> refraction, to_light, passes, stops_camera, stops_light;
    std::vector<int> singular;
    for (const ChainVertex& v : state.v) {
      refraction.push_back(v.log_refraction);
      to_light.push_back(v.pdf_to_light);
      singular.push_back(v.event != 0 ? 1 : 0);
      passes.push_back(v.before.log_pdf);
      stops_camera.push_back(v.log_stop_camera);
      stops_light.push_back(v.log_stop_light);
    }
    passes.push_back(state.end.before.log_pdf);
    row["log_passes"] = passes;
    row["log_stops_camera"] = stops_camera;
    row["log_stops_light"] = stops_light;
    row["log_refraction"] = refraction;
    row["pdf_to_light"] = to_light;
    row["singular"] = singular;
    row["pdf_sampled"] = state.end.pdf_sampled;
    row["pdf_met"] = state.end.pdf_met;
    nb::dict grown;
    for (size_t a = 0; a <= state.v.size(); ++a) {
      for (size_t b = 0; a + b <= state.v.size(); ++b) {
        grown[nb::make_tuple(a, b)] = chain.space.log_grown(state, a, b);
      }
    }
    row["grown"] = grown;
    result.append(row);
  }
  return result;
}

// For each of `chains` chains of `length` mutations, started as a render starts them, the longest
// run of mutations that were all rejected.
template <class Explorer>
std::vector<uint64_t> longest_rejections(const Ground& ground, uint32_t chains, uint64_t length,
                                         uint64_t seed) {
  RenderStats stats;
  const RenderContext context = ground.context();
  Batch batch;
  batch.samples = chains;
  batch.seed = seed;
  SeedPool<Explorer> pool(context, batch);
  for (int stage = 0; stage < pool.stages(); ++stage) {
    for (size_t job = 0; job < pool.jobs(stage); ++job) {
      pool.run(stage, job, context, stats);
    }
  }
  Explorer explorer(context, stats);
  const auto large = static_cast<float>(large_steps<Explorer>(context.settings));
  std::vector<uint64_t> longest;
  for (uint32_t i = 0; i < chains && pool.brightness() > 0.0; ++i) {
    MarkovChain<typename Explorer::State> chain;
    Pcg32 rng(hash64(seed + i));
    explorer.begin_chain(i, seed);
    const uint32_t start =
        pool.choose((static_cast<double>(i) + static_cast<double>(rng.next_float())) / chains);
    explorer.start(seed_sampler(batch, pool.size(), start), rng, chain);
    uint64_t run = 0, most = 0;
    for (uint64_t step = 0; step < length; ++step) {
      const double ratio = explorer.propose(chain, explorer.random() < large);
      const auto record = [](const Contribution&, double) {};
      if (metropolis_step(chain, ratio, explorer.random(), record)) {
        explorer.accept();
        run = 0;
      } else {
        most = std::max(most, ++run);
      }
    }
    longest.push_back(most);
  }
  return longest;
}

std::vector<uint64_t> rejection_runs(nb::handle handle,
                                     const std::map<std::string, SettingValue>& values,
                                     uint32_t chains, uint64_t length, uint64_t seed) {
  const Ground ground(handle, values);
  switch (static_cast<IntegratorKind>(ground.settings.integrator)) {
    case IntegratorKind::kPssmlt:
      return longest_rejections<SampleExplorer>(ground, chains, length, seed);
    case IntegratorKind::kMmlt:
      return longest_rejections<TechniqueExplorer>(ground, chains, length, seed);
    default:
      return longest_rejections<PathExplorer>(ground, chains, length, seed);
  }
}

// The target of a chain's start in a render that has been cancelled, and of what it goes on to.
template <class Explorer>
std::array<double, 2> start_when_cancelled(const RenderContext& context) {
  RenderStats stats;
  Explorer explorer(context, stats);
  MarkovChain<typename Explorer::State> chain;
  Pcg32 rng(1);
  explorer.begin_chain(0, 1);
  const double target = explorer.start(SobolSampler(0, 0, 0, 16, 1), rng, chain);
  explorer.propose(chain, false);
  return {target, chain.proposed.target};
}

std::array<double, 2> cancelled_start(nb::handle handle,
                                      const std::map<std::string, SettingValue>& values) {
  Ground ground(handle, values);
  ground.cancelled = true;
  switch (static_cast<IntegratorKind>(ground.settings.integrator)) {
    case IntegratorKind::kPssmlt:
      return start_when_cancelled<SampleExplorer>(ground.context());
    case IntegratorKind::kMmlt:
      return start_when_cancelled<TechniqueExplorer>(ground.context());
    default:
      return start_when_cancelled<PathExplorer>(ground.context());
  }
}

DirectionLobes direction_lobes(const Rows3& axes, const std::vector<float>& weights) {
  DirectionLobes lobes;
  for (size_t i = 0; i < weights.size(); ++i) {
    lobes.add(normalize({axes(i, 0), axes(i, 1), axes(i, 2)}), weights[i]);
  }
  lobes.finish();
  return lobes;
}

// u: (n, 3) in [0,1). Directions drawn from lobes about `axes` (at most 24, 3).
std::vector<std::array<float, 3>> lobe_directions(const Rows3& axes,
                                                  const std::vector<float>& weights,
                                                  const Rows3& u) {
  const DirectionLobes lobes = direction_lobes(axes, weights);
  std::vector<std::array<float, 3>> result;
  for (size_t i = 0; i < u.shape(0); ++i) {
    const Vec3f w = lobes.sample(u(i, 0), {u(i, 1), u(i, 2)});
    result.push_back({w.x, w.y, w.z});
  }
  return result;
}

std::vector<double> lobe_density(const Rows3& axes, const std::vector<float>& weights,
                                 const Rows3& directions) {
  const DirectionLobes lobes = direction_lobes(axes, weights);
  std::vector<double> result;
  for (size_t i = 0; i < directions.shape(0); ++i) {
    result.push_back(lobes.pdf(normalize({directions(i, 0), directions(i, 1), directions(i, 2)})));
  }
  return result;
}

}  // namespace

void bind_mutation_probes(nb::module_& m) {
  m.def("mutation_chain", &mutation_chain, nb::arg("scene"), nb::arg("settings"), nb::arg("name"),
        nb::arg("steps"), nb::arg("seed"), nb::arg("side"), nb::arg("longest"));
  m.def("grown_densities", &grown_densities, nb::arg("scene"), nb::arg("settings"),
        nb::arg("count"), nb::arg("seed"));
  m.def("rejection_runs", &rejection_runs, nb::arg("scene"), nb::arg("settings"), nb::arg("chains"),
        nb::arg("length"), nb::arg("seed"));
  m.def("cancelled_start", &cancelled_start, nb::arg("scene"), nb::arg("settings"));
  m.def("lobe_directions", &lobe_directions, nb::arg("axes"), nb::arg("weights"), nb::arg("u"));
  m.def("lobe_density", &lobe_density, nb::arg("axes"), nb::arg("weights"), nb::arg("directions"));
}

}  // namespace vernier
