#include "photons/photon_pass.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace vernier {
namespace {

constexpr uint64_t kPathsOfJob = 2048;
// What a later round starts beyond what seems to be needed, and no more than this many times what
// was started before.
constexpr double kSpare = 1.25;
constexpr uint64_t kMostGrowth = 8;

size_t jobs_of(uint64_t paths) {
  return static_cast<size_t>((paths + kPathsOfJob - 1) / kPathsOfJob);
}

}  // namespace

PhotonPass::PhotonPass(const std::vector<PhotonOrder>& orders, const Batch& batch) {
  for (const PhotonOrder& order : orders) {
    auto making = std::make_unique<Making>();
    making->order = order;
    // No two batches, and no two maps, share their numbers; nor do pixels.
    making->seed = hash64(batch.seed ^ hash64(~hash64(batch.first) + makings_.size()));
    makings_.push_back(std::move(making));
  }
}

int PhotonPass::stages() const {
  return makings_.empty() ? 0 : static_cast<int>(makings_.size()) * stages_of_map();
}

size_t PhotonPass::jobs(int stage) const {
  const Making& making = *makings_[static_cast<size_t>(stage / stages_of_map())];
  const int step = stage % stages_of_map();
  if (step >= 2 * kRounds) {
    return making.build.jobs(step - 2 * kRounds);
  }
  return step % 2 == 0 ? 1 : jobs_of(making.paths);
}

void PhotonPass::run(int stage, size_t job, const RenderContext& context, RenderStats& stats) {
  Making& making = *makings_[static_cast<size_t>(stage / stages_of_map())];
  const int step = stage % stages_of_map();
  if (step >= 2 * kRounds) {
    making.build.run(step - 2 * kRounds, job);
  } else if (step % 2 == 0) {
    begin_round(making, step / 2);
  } else {
    trace(making, step / 2, job, context, stats);
  }
}

void PhotonPass::begin_round(Making& making, int round) {
  const PhotonOrder& order = making.order;
  making.before += making.paths;
  if (round == 0) {
    making.paths = order.paths;
  } else {
    uint64_t found = 0;
    for (const PhotonChunk& chunk : making.chunks) {
      found += chunk.photons.size();
    }
    making.paths = 0;
    if (found < order.least && making.before < order.most_paths) {
      const double missing = static_cast<double>(order.least - found);
      const double each = static_cast<double>(std::max<uint64_t>(found, 1)) /
                          static_cast<double>(std::max<uint64_t>(making.before, 1));
      making.paths = std::min({static_cast<uint64_t>(std::ceil(missing / each * kSpare)),
                               kMostGrowth * making.before, order.most_paths - making.before});
    }
  }
  making.chunks.resize(jobs_of(making.paths) + making.chunks.size());
}

void PhotonPass::trace(Making& making, int round, size_t job, const RenderContext& context,
                       RenderStats& stats) {
  const uint64_t first = job * kPathsOfJob;
  const uint64_t last = std::min(first + kPathsOfJob, making.paths);
  PhotonChunk& chunk = making.chunks[making.chunks.size() - jobs_of(making.paths) + job];
  // Each round is a sequence of its own.
  const uint64_t seed = hash64(making.seed + static_cast<uint64_t>(round));
  const int log2_paths = std::bit_width(making.paths - 1);
  for (uint64_t i = first; i < last && !context.cancelled; ++i) {
    trace_photon(context, *making.order.guide, seed, static_cast<uint32_t>(i), log2_paths,
                 making.order.kinds, chunk, stats,
                 [](const EmissionSample&, const PhotonVisitor&) {});
  }
}

}  // namespace vernier
