#include "bidirectional/join_pilot.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "bidirectional/own_path_tally.h"
#include "bidirectional/pilot_loop.h"
#include "bidirectional/shared_paths.h"
#include "math/parallel.h"
#include "math/variance.h"

namespace vernier {
namespace {

// Rounds of learning: each chooses vertices by what the one before has learnt. What is chosen more
// often is also weighted higher, and so the second finds sharper differences than the first.
constexpr int kRounds = 2;
// Light paths for each sample: far more paths from the camera than from lights find the other side
// of a narrow opening only once they are shared.
constexpr uint32_t kPathsPerSample = 4;
// Joins of a camera vertex. Measured by error times processor time in the room behind a door ajar:
// 3.3 with 2 of them, 2.4 with 8, 2.7 with 16.
constexpr uint32_t kJoins = 8;
// Light cells, at most, as a logarithm, and of camera cells that much less.
constexpr int kMostLog2Cells = 8, kLog2Fewer = 3;
// A single contribution counts no more than this many times the picture there.
constexpr double kLargest = 16.0;
// Paths are shared where the product of variance and rays falls below this part of what it is
// without: a chosen vertex lies anywhere in memory and costs more than its ray.
constexpr double kWorthwhile = 0.5;
// Parts of the pilot, whose findings are added in their order.
constexpr uint32_t kParts = 16;

// What joins gave to the pixels whose paths they belong to, and how bright these are: a picture's
// error is judged relative to its brightness.
class JoinTally {
 public:
  explicit JoinTally(const FilmDesc& film) : own_(film) {}

  void emitted(const EmissionSample&) {}
  void traced_light(uint64_t rays) { own_.traced_light(rays); }
  void found(const FoundPath& path) {
    own_.found(path);
    if (path.t > 1 && path.s >= 2) {
      joins_.push_back({path.z->point.p, path.y->point.p, max_component(path.contribution), 0});
    }
  }
  // The sample whose paths were found is done.
  void sampled(Vec2f raster, Color radiance, const Subpath& camera) {
    const uint32_t at = own_.picture().pixel(raster);
    values_.push_back({max_component(radiance), at});
    own_.sampled(raster);
    for (; placed_ < joins_.size(); ++placed_) {
      joins_[placed_].pixel = at;
    }
    for (uint32_t i = 0; i < camera.size(); ++i) {
      if (camera[i].bsdf.connectible()) {
        joined_.push_back(camera[i].point.p);
      }
    }
  }
  void add(const JoinTally& other) {
    joins_.insert(joins_.end(), other.joins_.begin(), other.joins_.end());
    joined_.insert(joined_.end(), other.joined_.begin(), other.joined_.end());
    values_.insert(values_.end(), other.values_.begin(), other.values_.end());
    own_.add(other.own_);
  }

  // How much samples vary, relative to the brightness that `reference` found for their pixels.
  double relative_variance(const JoinTally& reference) const {
    const auto brightness = reference.own_.picture().brightness();
    Variance relative;
    for (const Value& value : values_) {
      relative.add(static_cast<double>(value.radiance) / brightness[value.pixel]);
    }
    return relative.value();
  }
  // Of the samples, of light paths and of what they bring.
  const OwnPathTally& own() const { return own_; }

  // Camera vertices that were joined.
  const std::vector<Vec3f>& joined() const { return joined_; }
  // Tells `guide`, by whose uses `joins` vertices were chosen for each, of `light_vertices` by
  // cell.
  void teach(JoinGuide& guide, uint32_t joins, const std::vector<double>& light_vertices) const {
    const uint32_t cameras = guide.camera_cells().count(), lights = guide.light_cells().count();
    CellPairs found(cameras, lights), tries(cameras, lights);
    const auto brightness = own_.picture().brightness();
    for (const Join& join : joins_) {
      found(guide.camera_cells()(join.camera), guide.light_cells()(join.light)) +=
          std::min(static_cast<double>(join.amount) / brightness[join.pixel], kLargest);
    }
    std::vector<double> vertices(cameras);  // by camera cell
    for (const Vec3f& p : joined_) {
      vertices[guide.camera_cells()(p)] += 1.0;
    }
    for (uint32_t z = 0; z < cameras; ++z) {
      double sum = 0.0;
      for (uint32_t y = 0; y < lights; ++y) {
        sum += guide.uses()(z, y) * light_vertices[y];
      }
      for (uint32_t y = 0; y < lights && sum > 0.0; ++y) {
        tries(z, y) = vertices[z] * joins * guide.uses()(z, y) * light_vertices[y] / sum;
      }
    }
    guide.learn(found, tries, light_vertices);
  }

 private:
  struct Join {
    Vec3f camera, light;
    float amount;
    uint32_t pixel;
  };

  struct Value {
    float radiance;
    uint32_t pixel;
  };

  OwnPathTally own_;
  std::vector<Join> joins_;
  std::vector<Vec3f> joined_;
  std::vector<Value> values_;  // of samples
  size_t placed_ = 0;          // joins whose pixel is known
};

// A fresh set of shared paths.
std::unique_ptr<SharedPaths> trace_paths(const RenderContext& context, const JoinGuide& guide,
                                         uint32_t count, uint64_t seed, RenderStats& stats) {
  auto paths = std::make_unique<SharedPaths>(guide, count, seed);
  for (int stage = 0; stage < paths->stages(); ++stage) {
    std::vector<RenderStats> of_job(paths->jobs(stage));
    parallel_for(of_job.size(), context.settings.threads,
                 [&](size_t job) { paths->run(stage, job, context, of_job[job]); });
    for (const RenderStats& job : of_job) {
      stats.rays += job.rays;
      stats.non_finite += job.non_finite;
    }
  }
  return paths;
}

// Samples that join camera vertices to `paths`.
JoinTally run_round(const RenderContext& context, uint64_t seed, uint32_t samples,
                    const SharedPaths* paths, RenderStats& stats) {
  std::vector<JoinTally> parts(kParts, JoinTally(context.scene.film));
  std::vector<RenderStats> of_part(kParts);
  const int log2_samples = static_cast<int>(std::bit_width(samples - 1));
  parallel_for(kParts, context.settings.threads, [&](size_t i) {
    const auto bound = [&](size_t part) { return static_cast<uint32_t>(samples * part / kParts); };
    run_pilot<false>(
        context, seed, log2_samples, bound(i), bound(i + 1), paths, of_part[i], parts[i],
        [&](Vec2f raster, const CameraSample& sample, const BidirectionalMemory& memory) {
          parts[i].sampled(raster, sample.radiance, memory.camera);
        });
  });
  JoinTally all(context.scene.film);
  for (size_t i = 0; i < kParts; ++i) {
    all.add(parts[i]);
    stats.rays += of_part[i].rays;
    stats.non_finite += of_part[i].non_finite;
  }
  return all;
}

// The vertices that can be joined, by light cell.
std::vector<double> count_vertices(const SharedPaths& paths, const SpaceCells& cells) {
  std::vector<double> vertices(cells.count());
  for (const Vec3f& p : paths.positions()) {
    vertices[cells(p)] += 1.0;
  }
  return vertices;
}

// Whether the same samples vary so much less with shared paths that it outweighs their cost.
bool pays(const RenderContext& context, uint64_t seed, uint32_t samples, JoinTally brightness,
          BidirectionalPlan& plan, RenderStats& stats) {
  RenderStats of_shared, of_own;
  const auto paths = trace_paths(context, plan.joins, samples * kPathsPerSample, seed, stats);
  const JoinTally shared = run_round(context, seed, samples, paths.get(), of_shared);
  const JoinGuide guide = std::exchange(plan.joins, JoinGuide());
  const JoinTally own = run_round(context, seed, samples, nullptr, of_own);
  plan.joins = guide;
  const double cost = static_cast<double>(of_shared.rays) / static_cast<double>(of_own.rays);
  stats.rays += of_shared.rays + of_own.rays;
  stats.non_finite += of_shared.non_finite + of_own.non_finite;
  brightness.add(shared);
  brightness.add(own);
  return shared.relative_variance(brightness) * cost <
         kWorthwhile * own.relative_variance(brightness);
}

}  // namespace

void learn_joins(const RenderContext& context, uint64_t seed, uint32_t samples,
                 BidirectionalPlan& plan, RenderStats& stats) {
  const auto sharing = static_cast<LightPathSharing>(context.settings.share_light_paths);
  if (sharing == LightPathSharing::kNever) {
    return;
  }
  RenderContext pilot = context;
  pilot.plan = &plan;
  const uint32_t count = std::max(samples / kRounds, kParts);
  const uint32_t light_paths = samples * kPathsPerSample;
  JoinGuide& guide = plan.joins;
  JoinTally brightness(context.scene.film);
  OwnPathTally own(context.scene.film);  // of the last round
  uint64_t rays = 0;                     // that its samples took
  std::vector<double> vertices;          // of a light path on average, by light cell
  for (uint64_t round = 0; round < kRounds && !context.cancelled; ++round) {
    const uint64_t round_seed = hash64(seed ^ hash64(round + 1));
    const auto paths = trace_paths(pilot, guide, light_paths, round_seed, stats);
    std::vector<Vec3f> lights = paths->positions();
    if (lights.empty()) {
      return;
    }
    if (round == 0) {
      vertices = {static_cast<double>(lights.size()) / paths->count()};
      guide.balance(kJoins, vertices);
    }
    RenderStats of_round;
    const JoinTally tally = run_round(pilot, round_seed, count, paths.get(), of_round);
    stats.rays += of_round.rays;
    stats.non_finite += of_round.non_finite;
    brightness.add(tally);
    own = tally.own();
    rays = of_round.rays;
    if (round == 0) {
      std::vector<Vec3f> cameras = tally.joined();
      const double tries = static_cast<double>(cameras.size()) * kJoins;
      const int log2_lights =
          std::clamp(static_cast<int>(0.5 * std::log2(tries + 1.0)), 0, kMostLog2Cells);
      guide = JoinGuide(SpaceCells(std::move(cameras), std::max(log2_lights - kLog2Fewer, 0)),
                        SpaceCells(std::move(lights), log2_lights));
    }
    const std::vector<double> counts = count_vertices(*paths, guide.light_cells());
    tally.teach(guide, kJoins, counts);
    vertices = counts;
    for (double& of_cell : vertices) {
      of_cell /= paths->count();
    }
    guide.balance(kJoins, vertices);
  }
  if (sharing == LightPathSharing::kAuto &&
      !pays(pilot, hash64(seed), count, std::move(brightness), plan, stats)) {
    guide = JoinGuide();
  } else {
    plan.own_paths = own.part(rays, true);
  }
}

}  // namespace vernier
