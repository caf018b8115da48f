// A probe of whole paths: their densities, weights and throughputs are made anew and compared.
#include <nanobind/stl/array.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/variant.h>
#include <nanobind/stl/vector.h>

#include "bidirectional/path_verifier.h"
#include "bidirectional/plan.h"
#include "bidirectional/shared_paths.h"
#include "bidirectional/tracer.h"
#include "bindings/bind.h"
#include "bindings/probe_render.h"

namespace nb = nanobind;

namespace vernier {
namespace {

// Traces `samples` samples of every pixel and verifies each path that they find, with the plan that
// a pilot makes or without one. A dictionary of
// (count, failures, worst, worst path) by check, of counts by technique, and of what was left out.
nb::dict verify_paths(nb::handle handle, const std::map<std::string, SettingValue>& values,
                      uint32_t samples, double tolerance, bool pilot) {
  ProbeRender render(handle, values);
  render.settings.roulette_threshold = 0.0;  // throughputs are to be those of the densities
  const Scene* scene = render.scene.get();
  const Settings& settings = render.settings;
  RenderStats& stats = render.stats;
  RenderContext context = render.context();
  BidirectionalPlan plan;
  plan.guide = scene->lights->guide_by_power();
  plan.footprint = scene->camera->footprint(scene->center);
  if (pilot) {
    const auto made = make_bidirectional_plan(context, static_cast<uint64_t>(settings.seed), stats);
    plan = static_cast<const BidirectionalPlan&>(*made);
    plan.inverse_threshold = kInfinity;  // nothing is let go by chance
  }
  context.plan = &plan;
  const bool shares = plan.joins.shares();
  SharedPaths shared(plan.joins, shares ? 1024 : 0, static_cast<uint64_t>(settings.seed));
  for (int stage = 0; stage < shared.stages(); ++stage) {
    for (size_t job = 0; job < shared.jobs(stage); ++job) {
      shared.run(stage, job, context, stats);
    }
  }
  const auto& crop = scene->film.crop;
  SplatFrame splats(crop[2] - crop[0], crop[3] - crop[1], false);
  BidirectionalMemory memory;
  // Merged with what paths of a batch of their own leave.
  LightVertices vertices(context, Batch{.seed = ~static_cast<uint64_t>(settings.seed)});
  const bool merges = TechniqueSet(settings, scene->requirements).merges;
  for (int stage = 0; merges && stage < vertices.stages(); ++stage) {
    for (size_t job = 0; job < vertices.jobs(stage); ++job) {
      vertices.run(stage, job, context, stats);
    }
  }
  context.light_pass = &vertices;
  PathVerifier verifier(*scene, settings, plan.guide, memory, tolerance,
                        merges ? &vertices : nullptr, shares ? &plan.joins : nullptr,
                        plan.own_paths);
  NoPassSample passes;
  const auto trace = [&](const CameraRay& ray, const SobolSampler& sampler) {
    if (merges) {
      BidirectionalTracer<BidirectionalFeatures{false, true, true}, PathVerifier>(
          context, sampler, stats, &splats, passes, memory, verifier)
          .run(ray);
    } else {
      BidirectionalTracer<BidirectionalFeatures{false, true}, PathVerifier>(
          context, sampler, stats, &splats, passes, memory, verifier, shares ? &shared : nullptr)
          .run(ray);
    }
  };
  render.for_each_camera_ray(
      samples, static_cast<uint64_t>(settings.seed),
      [&](int, int, const CameraRay& ray, const SobolSampler& sampler) { trace(ray, sampler); });
  const PathReport& report = verifier.report();
  nb::dict result;
  for (size_t i = 0; i < report.checks.size(); ++i) {
    const PathReport::Check& check = report.checks[i];
    result[kPathCheckNames[i]] =
        nb::make_tuple(check.count, check.failures, check.worst, check.worst_path);
  }
  const auto counts = [](const std::map<std::pair<int, int>, uint64_t>& of) {
    nb::dict by_technique;
    for (const auto& [technique, count] : of) {
      by_technique[nb::make_tuple(technique.first, technique.second)] = count;
    }
    return by_technique;
  };
  result["techniques"] = counts(report.techniques);
  result["merges"] = counts(report.merges);
  result["own_paths"] = plan.own_paths;
  result["uneven"] = report.uneven;
  result["unseen"] = report.unseen;
  result["non_finite"] = stats.non_finite;
  return result;
}

// Follows the camera's rays as far as they go straight on.
struct SightVisitor {
  const Scene& scene;
  PathVertex last{};
  float sharpest = kInfinity;

  bool segment(const Walk&, const Ray&, bool) { return true; }
  PathVertex& vertex() { return last; }
  bool arrive(const Walk&, const PathVertex& v) {
    const bool reached =
        !v.traits->path_dependent &&
        (scene.instances[v.point.instance].visibility & kVisibleScattered) == kVisibleScattered;
    sharpest = std::min(sharpest, reached ? v.bsdf.sharpest_glossy() : 0.0f);
    return true;
  }
  void pass(const PathVertex&) {}
  void leave(const PathVertex&, const BsdfSample&) {}
};

// Of each pixel of the film, (y, x), the least squared roughness of what `samples` of its rays see
// first: 0 where a part of it is a perfect mirror or glass, or cannot be reached by paths from
// lights, and so nothing of it can be splatted; infinite where all is diffuse.
std::vector<std::vector<float>> sharpest_seen(nb::handle handle, uint32_t samples) {
  ProbeRender render(handle, {});
  render.settings.roulette_threshold = 0.0;
  const Scene& scene = *render.scene;
  const auto& crop = scene.film.crop;
  std::vector<std::vector<float>> rows(
      static_cast<size_t>(crop[3] - crop[1]),
      std::vector<float>(static_cast<size_t>(crop[2] - crop[0]), kInfinity));
  render.for_each_camera_ray(
      samples, 0, [&](int x, int y, const CameraRay& ray, const SobolSampler& sampler) {
        SightVisitor visitor{scene};
        Walk walk;
        walk.most_bounces = 0;
        walk.ray = ray.ray;
        random_walk(WalkContext<>{scene, sampler, render.cancelled, BounceLimits(render.settings),
                                  Roulette(render.settings), render.stats.rays},
                    walk, visitor);
        float& sharpest = rows[static_cast<size_t>(y - crop[1])][static_cast<size_t>(x - crop[0])];
        sharpest = std::min(sharpest, visitor.sharpest);
      });
  return rows;
}

// Rows (u_select, u_position, u_direction) into rows of the density with which a ray was made, over
// area across it and solid angle, by its own sample and as the density of any such ray: equal, or
// both 0 where the sample has no radiance.
std::vector<std::array<double, 2>> emission_ray_densities(
    nb::handle handle, const std::vector<std::array<float, 5>>& u) {
  const auto scene = scene_of(handle);
  const LightSampler& lights = *scene->lights;
  const EmissionGuide& guide = lights.guide_by_power();
  std::vector<std::array<double, 2>> rows(u.size());
  for (size_t i = 0; i < u.size(); ++i) {
    EmissionSample e;
    if (!lights.sample_emission(guide, u[i][0], {u[i][1], u[i][2]}, {u[i][3], u[i][4]}, e)) {
      continue;
    }
    // Somewhere along the ray, outside of what it starts from.
    const Vec3f p = e.p + e.direction * (0.5f * scene->radius + e.lit_from);
    rows[i] = {static_cast<double>(e.pdf_position) * static_cast<double>(e.pdf_direction) *
                   static_cast<double>(e.pdf_selection) / static_cast<double>(e.cosine),
               static_cast<double>(lights.pdf_emission_ray(guide, e.light, p, e.direction))};
  }
  return rows;
}

// The weights of all techniques that make a path, in the plain form and in the recursive one. Rows
// of surfaces: p, ng, pdf_to_light, pdf_to_camera, singular, light_reaches, camera_sees,
// light_crosses, merge_area. Ends: the camera's direction and pdf_across; the light's direction,
// pdf_sampled, pdf_emitted, hittable, light_crosses.
std::array<std::vector<double>, 2> mis_weights(const std::vector<std::array<double, 13>>& surfaces,
                                               const std::array<double, 11>& ends, bool power,
                                               bool joins, bool merges) {
  const auto vec = [](const double* x) {
    return Vec3f{static_cast<float>(x[0]), static_cast<float>(x[1]), static_cast<float>(x[2])};
  };
  Path path;
  path.camera = {vec(&ends[0]), ends[3]};
  path.light = {vec(&ends[4]), ends[7], ends[8], ends[9] != 0.0, ends[10] != 0.0};
  path.joins = joins;
  path.merges = merges;
  for (const std::array<double, 13>& row : surfaces) {
    path.surfaces.push_back({vec(&row[0]), vec(&row[3]), row[6], row[7], row[8] != 0.0,
                             row[9] != 0.0, row[10] != 0.0, row[11] != 0.0, row[12]});
  }
  return {technique_weights(technique_log_pdfs(path), power),
          recursive_weights(path, MisHeuristic(power, joins))};
}

}  // namespace

void bind_paths_probes(nb::module_& m) {
  m.def("verify_paths", &verify_paths, nb::arg("scene"), nb::arg("settings"), nb::arg("samples"),
        nb::arg("tolerance"), nb::arg("pilot"));
  m.def("sharpest_seen", &sharpest_seen, nb::arg("scene"), nb::arg("samples"));
  m.def("emission_ray_densities", &emission_ray_densities);
  m.def("mis_weights", &mis_weights);
}

}  // namespace vernier
