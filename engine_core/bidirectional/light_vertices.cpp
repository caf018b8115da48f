#include "bidirectional/light_vertices.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "paths/light_walk.h"

namespace vernier {
namespace {

// Paths of a job.
constexpr size_t kPathsOfPart = 1024;

size_t pixels_of(const std::array<int32_t, 4>& crop) {
  return static_cast<size_t>(crop[2] - crop[0]) * static_cast<size_t>(crop[3] - crop[1]);
}

float as_float(double ratio) {
  return static_cast<float>(
      std::min(ratio, static_cast<double>(std::numeric_limits<float>::max())));
}

// Collects the vertices of one path after the other.
struct Collector {
  std::vector<Vec3f>& positions;
  std::vector<LightVertex>& vertices;
  uint32_t path = 0;

  void emitted(const EmissionSample&) {}
  void reached(const Walk& walk, const PathVertex& v) {
    if (!(v.mis.merge > 0.0)) {
      return;
    }
    const MergeRatios ratios = v.mis.beside_merge();
    positions.push_back(v.point.p);
    vertices.push_back({v.point.ng, v.point.wo, v.beta, as_float(ratios.neighbour),
                        as_float(ratios.chain), path, walk.depth});
  }
};

}  // namespace

float merge_radius(const Settings& settings, float footprint, uint32_t sample) {
  const double shrunk =
      std::pow(static_cast<double>(sample) + 1.0, 0.5 * (settings.merge_alpha - 1.0));
  const double radius = settings.merge_radius * static_cast<double>(footprint) * shrunk;
  // What the grid can hold: beyond all scenes.
  return radius >= 1e-18 ? static_cast<float>(std::min(radius, 1e18)) : 0.0f;
}

LightVertices::LightVertices(const TechniqueSet& techniques, const Crop& crop, uint64_t seed,
                             int log2_capacity, uint32_t first, size_t count, float radius)
    : techniques_(techniques),
      crop_(crop),
      seed_(seed),
      log2_capacity_(log2_capacity),
      first_(first),
      paths_(count),
      radius_(radius),
      area_(static_cast<double>(count) * static_cast<double>(kPi) *
            square(static_cast<double>(radius))),
      parts_((count + kPathsOfPart - 1) / kPathsOfPart),
      grid_build_(std::in_place, grid_, std::span<const Vec3f>{}, radius) {}

LightVertices::LightVertices(const RenderContext& context, const Batch& batch)
    : LightVertices(TechniqueSet(context.settings, context.scene.requirements),
                    context.scene.film.crop, batch.seed, batch.log2_capacity, batch.point,
                    pixels_of(context.scene.film.crop),
                    merge_radius(context.settings,
                                 static_cast<const BidirectionalPlan&>(*context.plan).footprint,
                                 batch.first)) {}

SobolSampler LightVertices::sampler(size_t i) const {
  const auto number = static_cast<uint32_t>(i);
  if (crop_[0] == crop_[2]) {
    return {0, 0, first_ + number, log2_capacity_, seed_};
  }
  // The very path that the pixel's own sample joins to the camera's.
  const auto width = static_cast<uint32_t>(crop_[2] - crop_[0]);
  return {static_cast<uint32_t>(crop_[0]) + number % width,
          static_cast<uint32_t>(crop_[1]) + number / width, first_, log2_capacity_, seed_};
}

int LightVertices::stages() const { return radius_ > 0.0f ? kGrid + grid_build_->stages() : 0; }

size_t LightVertices::jobs(int stage) const {
  switch (stage) {
    case kTrace:
    case kGather:
      return parts_.size();
    case kLayOut:
      return 1;
    default:
      return grid_build_->jobs(stage - kGrid);
  }
}

void LightVertices::run(int stage, size_t job, const RenderContext& context, RenderStats& stats) {
  switch (stage) {
    case kTrace:
      return trace(parts_[job], job * kPathsOfPart, std::min((job + 1) * kPathsOfPart, paths_),
                   context, stats);
    case kLayOut: {
      size_t count = 0;
      for (Part& part : parts_) {
        part.first = count;
        count += part.vertices.size();
      }
      positions_.resize(count);
      vertices_.resize(count);
      grid_build_.emplace(grid_, positions_, radius_);
      return;
    }
    case kGather: {
      Part& part = parts_[job];
      const auto first = static_cast<ptrdiff_t>(part.first);
      std::copy(part.positions.begin(), part.positions.end(), positions_.begin() + first);
      std::copy(part.vertices.begin(), part.vertices.end(), vertices_.begin() + first);
      part = Part{};
      return;
    }
    default:
      return grid_build_->run(stage - kGrid, job);
  }
}

void LightVertices::trace(Part& part, size_t first, size_t last, const RenderContext& context,
                          RenderStats& stats) const {
  const LightEnds ends{context.scene, static_cast<const BidirectionalPlan&>(*context.plan).guide,
                       techniques_.heuristic(context.settings), area_};
  Subpath path;
  Collector collector{part.positions, part.vertices};
  for (size_t i = first; i < last && !context.cancelled; ++i) {
    const SobolSampler numbers = sampler(i);
    const WalkContext walks{context.scene,
                            numbers,
                            context.cancelled,
                            BounceLimits::of_both_sides(context.settings),
                            Roulette(context.settings),
                            stats.rays};
    collector.path = static_cast<uint32_t>(i);
    path.clear();
    walk_from_light(ends, walks, path, stats.non_finite, collector);
  }
}

std::unique_ptr<LightPass> make_light_vertices(const RenderContext& context, const Batch& batch) {
  return std::make_unique<LightVertices>(context, batch);
}

}  // namespace vernier
