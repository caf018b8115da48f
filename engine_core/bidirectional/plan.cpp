#include "bidirectional/plan.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "bidirectional/emission_learning.h"
#include "bidirectional/join_pilot.h"
#include "bidirectional/light_vertices.h"
#include "bidirectional/own_path_tally.h"
#include "bidirectional/pilot_loop.h"
#include "math/parallel.h"

namespace vernier {
namespace {

// Samples of the pilot: this part of the render's, within these powers of two.
constexpr double kPilotPart = 1.0 / 64.0;
constexpr int kLeastLog2 = 10, kMostLog2 = 14;
// The part of them, one in this many, that finds out where to aim; the rest is aimed.
constexpr uint32_t kAimingPart = 4;
// Merges of the pilot reach so much farther than those of a picture with as many pixels would.
constexpr float kPilotBlur = 2.0f;
// Another part of as many finds out which light paths are worth sharing.
constexpr uint32_t kJoiningPart = 2;
// A contribution is small where it is below this part of the picture's mean. Measured by error
// times processor time: 0.03, 0.1 and 0.3 differ by a fifth at the most in the Cornell box and the
// caustics, and 0.1 is the best of them on both together.
constexpr double kSmallPart = 0.1;

// Adds up what each light does for the picture.
struct LightTally : EmissionTally {
  double total = 0.0;
  const EmissionGuide* guide = nullptr;  // null: what cells there are is not known yet
  const std::vector<EmissionOrigin>* origins = nullptr;  // of the paths that are merged with others
  EmissionOrigin own;                                    // of the sample's
  OwnPathTally own_paths;

  LightTally(uint32_t lights, const FilmDesc& film) : EmissionTally(lights), own_paths(film) {}

  void add(const LightTally& other) {
    EmissionTally::add(other);
    total += other.total;
    own_paths.add(other.own_paths);
  }

  void traced_light(uint64_t rays) { own_paths.traced_light(rays); }
  void emitted(const EmissionSample& e) {
    own = guide ? EmissionOrigin(*guide, e) : EmissionOrigin();
  }

  void found(const FoundPath& path) {
    const auto amount = static_cast<double>(max_component(path.contribution));
    total += amount;
    own_paths.found(path);
    const EmissionOrigin& origin = path.merged ? (*origins)[path.light_path] : own;
    const uint32_t light = path.merged ? origin.light : path.light;
    if (light == kNoIndex) {
      return;
    }
    by_light[light] += amount;
    if (path.s >= 2) {
      credit(origin, light, amount);
    }
  }
};

// The median of what a pixel covers at the points.
float median_footprint(const std::vector<Vec3f>& points, const Camera& camera) {
  std::vector<float> footprints;
  footprints.reserve(points.size());
  for (const Vec3f& p : points) {
    footprints.push_back(camera.footprint(p));
  }
  if (footprints.empty()) {
    return 0.0f;
  }
  const auto middle = footprints.begin() + static_cast<ptrdiff_t>(footprints.size() / 2);
  std::nth_element(footprints.begin(), middle, footprints.end());
  return *middle;
}

// What a pilot finds out.
struct Findings {
  LightTally tally;
  std::vector<Vec3f> points;  // the first surfaces that the camera's paths visit
  RenderStats stats;

  Findings(uint32_t lights, const FilmDesc& film) : tally(lights, film) {}
};

// Samples `first` to `last` of the pilot, on all threads. Parts are added in their order: the plan
// does not depend on the threads.
Findings run_pilot(const RenderContext& context, uint64_t seed, int log2_samples, uint32_t first,
                   uint32_t last, const EmissionGuide* cells,
                   const std::vector<EmissionOrigin>* origins) {
  constexpr uint32_t kParts = 16;
  const uint32_t lights = context.scene.lights->count();
  std::vector<Findings> parts(kParts, Findings(lights, context.scene.film));
  const auto bound = [&](size_t part) {
    return first + static_cast<uint32_t>((last - first) * part / kParts);
  };
  parallel_for(kParts, context.settings.threads, [&](size_t i) {
    Findings& found = parts[i];
    found.tally.guide = cells;
    found.tally.origins = origins;
    const auto keep = [&](Vec2f raster, const CameraSample&, const BidirectionalMemory& memory) {
      found.tally.own_paths.sampled(raster);
      const Subpath& path = memory.camera;
      for (uint32_t v = 0; v < path.size() && path[v].point.depth.total <= 1; ++v) {
        found.points.push_back(path[v].point.p);
      }
    };
    const auto run = [&]<bool kMerging> {
      run_pilot<kMerging>(context, seed, log2_samples, bound(i), bound(i + 1), nullptr, found.stats,
                          found.tally, keep);
    };
    if (context.light_pass != nullptr) {
      run.template operator()<true>();
    } else {
      run.template operator()<false>();
    }
  });
  Findings all(lights, context.scene.film);
  for (const Findings& part : parts) {
    all.tally.add(part.tally);
    all.points.insert(all.points.end(), part.points.begin(), part.points.end());
    all.stats.rays += part.stats.rays;
    all.stats.non_finite += part.stats.non_finite;
  }
  return all;
}

// Makes the light pass, on all threads. Returns where its paths begin.
std::vector<EmissionOrigin> trace_light(const RenderContext& context, LightVertices& vertices,
                                        size_t paths, RenderStats& stats) {
  for (int stage = 0; stage < vertices.stages(); ++stage) {
    std::vector<RenderStats> done(vertices.jobs(stage));
    parallel_for(done.size(), context.settings.threads, [&](size_t job) {
      const FlushDenormals flush;
      vertices.run(stage, job, context, done[job]);
    });
    for (const RenderStats& of_job : done) {
      stats.rays += of_job.rays;
      stats.non_finite += of_job.non_finite;
    }
  }
  const EmissionGuide& guide = static_cast<const BidirectionalPlan&>(*context.plan).guide;
  std::vector<EmissionOrigin> origins(paths);
  for (size_t i = 0; i < paths; ++i) {
    EmissionSample e;
    if (emit(*context.scene.lights, guide, vertices.sampler(i), e)) {
      origins[i] = EmissionOrigin(guide, e);
    }
  }
  return origins;
}

}  // namespace

std::unique_ptr<const Plan> make_bidirectional_plan(const RenderContext& context, uint64_t seed,
                                                    RenderStats& stats) {
  const Scene& scene = context.scene;
  auto plan = std::make_unique<BidirectionalPlan>();
  plan->guide = scene.lights->guide_by_power();
  const std::array<int32_t, 4>& crop = scene.film.crop;
  const double pixels =
      static_cast<double>(crop[2] - crop[0]) * static_cast<double>(crop[3] - crop[1]);
  const double samples = pixels * context.settings.samples;
  const int log2_samples =
      std::clamp(std::ilogb(std::max(samples * kPilotPart, 1.0)), kLeastLog2, kMostLog2);
  const uint32_t count = 1u << log2_samples;
  const uint32_t aiming = count / kAimingPart;
  Settings settings = context.settings;
  settings.vcm_connections = 1;  // what joins find as well tells where light comes from
  RenderContext pilot{scene, settings, context.filter, context.cancelled, plan.get()};
  Findings unaimed = run_pilot(pilot, seed, log2_samples, 0, aiming, nullptr, nullptr);
  plan->footprint = median_footprint(unaimed.points, *scene.camera);
  aim_at(unaimed.points, scene, plan->guide);
  const TechniqueSet techniques(settings, scene.requirements);
  // As a picture of so many pixels would have it.
  const float radius = merge_radius(
      settings,
      plan->footprint * kPilotBlur * static_cast<float>(std::sqrt(pixels / (count - aiming))), 0);
  LightVertices vertices(techniques, pilot_seed(seed), log2_samples, aiming, count - aiming,
                         radius);
  std::vector<EmissionOrigin> origins;
  if (techniques.merges) {
    origins = trace_light(pilot, vertices, count - aiming, stats);
    pilot.light_pass = &vertices;
  }
  const Findings aimed =
      run_pilot(pilot, seed, log2_samples, aiming, count, &plan->guide, &origins);
  for (const Findings* found : {&std::as_const(unaimed), &aimed}) {
    stats.rays += found->stats.rays;
    stats.non_finite += found->stats.non_finite;
  }
  const LightTally& tally = aimed.tally;
  if (tally.total > 0.0) {
    plan->inverse_threshold = static_cast<float>((count - aiming) / (kSmallPart * tally.total));
    choose_by(tally, plan->guide);
    direct_by(tally, *scene.lights, plan->guide);
    const auto kind = static_cast<IntegratorKind>(settings.integrator);
    if (kind == IntegratorKind::kBdpt || (kind == IntegratorKind::kVcm && !techniques.merges)) {
      learn_joins(pilot, seed, count / kJoiningPart, *plan, stats);
      if (!plan->joins.shares()) {
        plan->own_paths = tally.own_paths.part(aimed.stats.rays, false);
      }
    }
  }
  return plan;
}

}  // namespace vernier
