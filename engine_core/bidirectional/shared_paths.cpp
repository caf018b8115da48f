#include "bidirectional/shared_paths.h"

#include <algorithm>
#include <bit>
#include <numeric>

#include "bidirectional/plan.h"
#include "paths/light_walk.h"

namespace vernier {
namespace {

// Paths of a job, and in all at most: memory stays bounded.
constexpr uint32_t kGroup = 256, kMostPaths = 1u << 14;
// Where a batch has few samples, shared paths take no more of its time than this part of them.
constexpr double kPart = 0.25;

uint32_t count_paths(const FilmDesc& film, const Batch& batch) {
  const double samples = static_cast<double>(film.crop[2] - film.crop[0]) *
                         static_cast<double>(film.crop[3] - film.crop[1]) * batch.samples;
  return static_cast<uint32_t>(std::clamp(kPart * samples, 1.0, double{kMostPaths}));
}

struct NumberOfLight {
  uint32_t light = kNoIndex;

  void emitted(const EmissionSample& e) { light = e.light; }
  void reached(const Walk&, const PathVertex&) {}
};

}  // namespace

SharedPaths::SharedPaths(const JoinGuide& guide, uint32_t paths, uint64_t seed)
    : guide_(guide),
      paths_(std::min(paths, kMostPaths)),
      seed_(seed),
      groups_((paths_ + kGroup - 1) / kGroup) {}

void SharedPaths::run(int stage, size_t job, const RenderContext& context, RenderStats& stats) {
  if (stage == 0) {
    trace(job, context, stats);
    return;
  }
  sort();
}

void SharedPaths::sort() {
  const uint32_t cells = guide_.light_cells().count();
  first_.assign(cells + 1, 0);
  for (const Group& group : groups_) {
    for (const uint32_t cell : group.cells) {
      if (cell != kNoIndex) {
        ++first_[cell + 1];
      }
    }
  }
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  places_.resize(first_.back());
  std::vector<uint32_t> next(first_.begin(), first_.end() - 1);
  for (uint32_t g = 0; g < groups_.size(); ++g) {
    const std::vector<uint32_t>& of = groups_[g].cells;
    for (uint32_t i = 0; i < of.size(); ++i) {
      if (of[i] != kNoIndex) {
        places_[next[of[i]]++] = {JoinEnd(groups_[g].vertices[i], i), g, groups_[g].lights[i]};
      }
    }
  }
  std::vector<double> weights(cells);
  for (uint32_t z = 0; z < guide_.camera_cells().count(); ++z) {
    for (uint32_t y = 0; y < cells; ++y) {
      weights[y] = guide_.uses()(z, y) * (first_[y + 1] - first_[y]);
    }
    choices_.emplace_back(weights);
  }
}

void SharedPaths::trace(size_t job, const RenderContext& context, RenderStats& stats) {
  const auto& plan = static_cast<const BidirectionalPlan&>(*context.plan);
  const bool power =
      static_cast<MisExponent>(context.settings.mis_heuristic) == MisExponent::kPower;
  const LightEnds ends{context.scene, plan.guide, MisHeuristic(power), 0.0, &guide_};
  Group& group = groups_[job];
  Subpath path;
  const auto first = static_cast<uint32_t>(job) * kGroup;
  const uint32_t last = std::min(first + kGroup, paths_);
  for (uint32_t i = first; i < last && !context.cancelled; ++i) {
    const SobolSampler sampler(0, 0, i, static_cast<int>(std::bit_width(paths_ - 1u)), seed_);
    const WalkContext<> walks{context.scene,
                              sampler,
                              context.cancelled,
                              BounceLimits::of_both_sides(context.settings),
                              Roulette(context.settings),
                              stats.rays};
    path.clear();
    NumberOfLight client;
    walk_from_light(ends, walks, path, stats.non_finite, client);
    const auto base = static_cast<uint32_t>(group.vertices.size());
    for (uint32_t k = 0; k < path.size(); ++k) {
      PathVertex& v = group.vertices.emplace_back(path[k]);
      v.parent = v.parent == kNoIndex ? kNoIndex : v.parent + base;
      group.lights.push_back(client.light);
      group.cells.push_back(v.bsdf.connectible() ? guide_.light_cells()(v.point.p) : kNoIndex);
    }
  }
}

std::vector<Vec3f> SharedPaths::positions() const {
  std::vector<Vec3f> positions;
  for (const Place& place : places_) {
    positions.push_back(place.end.p);
  }
  return positions;
}

SharedPaths::Choice SharedPaths::choose(Vec3f p, Vec2f u, const JoinEnd*& end) const {
  const AliasTable& cells = choices_[guide_.camera_cells()(p)];
  const uint32_t cell = cells.sample(u.x);
  const uint32_t count = first_[cell + 1] - first_[cell];
  const auto within = static_cast<uint32_t>(u.y * static_cast<float>(count));
  const Place& place = places_[first_[cell] + std::min(within, count - 1)];
  const Group& group = groups_[place.group];
  const double probability = static_cast<double>(cells.probability(cell)) / count;
  end = &place.end;
  return {&group.vertices[place.end.number], group.vertices.data(), place.light,
          guide_.count() * probability * paths_};
}

std::unique_ptr<LightPass> make_shared_paths(const RenderContext& context, const Batch& batch) {
  const JoinGuide& joins = static_cast<const BidirectionalPlan&>(*context.plan).joins;
  if (!joins.shares()) {
    return nullptr;
  }
  return std::make_unique<SharedPaths>(
      joins, count_paths(context.scene.film, batch),
      hash64(batch.seed ^ hash64(~static_cast<uint64_t>(batch.first))));
}

}  // namespace vernier
