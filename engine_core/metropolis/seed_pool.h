// The independent samples of one batch: from them its chains start, by them its brightness is
// known, and the dim parts of the picture are theirs.
//
// A chain that starts at one of n independent samples, chosen in proportion to their targets, and
// whose visits count by the mean of these targets, has from its first step on the expectation of a
// chain in equilibrium (Veach 1997, section 11.3.1): there is no start-up bias, at any length and
// for any n. All chains of a batch draw from one pool. Batches have pools of their own, so that the
// brightness is estimated for as long as the render runs, and batches are independent.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "integrators/filtered_splats.h"
#include "integrators/integrator.h"
#include "math/float_environment.h"
#include "metropolis/contribution.h"
#include "metropolis/metropolis_plan.h"
#include "metropolis/primary_explorer.h"
#include "sampling/sobol.h"

namespace vernier {

// How a batch's evaluations are shared out.
struct PoolSize {
  double pixels;        // that are rendered
  double mutations;     // of all chains
  uint32_t seeds;       // independent samples of the pool
  int log2_seeds;       // rounded up
  double independents;  // expected number of them and of large steps together

  // `share`: the pool's size over the number of mutations. `large_steps`: the part of them that are
  // independent samples too.
  PoolSize(const RenderContext& context, const Batch& batch, double share, double large_steps) {
    const std::array<int32_t, 4>& crop = context.scene.film.crop;
    pixels = static_cast<double>(crop[2] - crop[0]) * static_cast<double>(crop[3] - crop[1]);
    mutations = pixels * batch.samples;
    seeds = static_cast<uint32_t>(std::clamp(share * mutations, kLeast, kMost));
    log2_seeds = std::bit_width(seeds - 1u);
    independents = seeds + large_steps * mutations;
  }

 private:
  static constexpr double kLeast = 64, kMost = 1 << 22;
};

// What part of a point of this target is the chains': the rest is that of independent samples. It
// is the balance heuristic, but for a scale that is fixed beforehand so that both stay unbiased
// (Kelemen et al. 2002, section 4, with the brightness as it is estimated there).
class ChainShare {
 public:
  ChainShare(double scale, double independents_per_mutation)
      : half_(scale * independents_per_mutation) {}
  // `target` may be infinite.
  double chain(double target) const { return 1.0 - independent(target); }
  double independent(double target) const { return half_ / (target + half_); }

 private:
  double half_;  // the target at which both have one half
};

// The number that u in [0,1] chooses in proportion to what each adds to `sums`: one that adds
// something, where any does, however u is rounded.
inline uint32_t choose_by_sums(const std::vector<double>& sums, double u) {
  const double at = u * sums.back();
  const auto found = at < sums.back() ? std::upper_bound(sums.begin(), sums.end(), at)
                                      : std::lower_bound(sums.begin(), sums.end(), sums.back());
  return static_cast<uint32_t>(found - sums.begin());
}

// The sample of a pool with this number.
inline SobolSampler seed_sampler(const Batch& batch, const PoolSize& size, uint32_t number) {
  return {0, 0, number, size.log2_seeds, hash64(batch.seed ^ hash64(0x706f6f6cull + batch.first))};
}

// The part of a method's mutations that leave the path for a new one.
template <class Explorer>
double large_steps(const Settings& settings) {
  return settings.large_steps > 0.0 ? settings.large_steps : Explorer::kLargeSteps;
}

template <class Explorer>
class SeedPool : public LightPass {
 public:
  SeedPool(const RenderContext& context, const Batch& batch)
      : batch_(batch),
        size_(context, batch, Explorer::kPoolShare,
              Explorer::kIndependentSteps ? large_steps<Explorer>(context.settings) : 0.0),
        targets_(size_.seeds),
        splats_(context.scene.film.crop[2] - context.scene.film.crop[0],
                context.scene.film.crop[3] - context.scene.film.crop[1], false) {}

  int stages() const override { return 2; }
  size_t jobs(int stage) const override { return stage == 0 ? kJobs : 1; }

  void run(int stage, size_t job, const RenderContext& context, RenderStats& stats) override {
    if (stage == 1) {
      sum();
      return;
    }
    const auto& plan = static_cast<const MetropolisPlan&>(*context.plan);
    if (!plan.chains) {
      return;
    }
    const FlushDenormals flush;
    const ChainShare share(plan.scale, size_.independents / size_.mutations);
    const FilteredSplats splats(context.scene.film, context.filter, &splats_);
    PrimaryEvaluator evaluator(context, stats, Explorer::kWholePaths);
    Contribution contribution;
    const auto bound = [&](size_t i) {
      return static_cast<uint32_t>(static_cast<uint64_t>(size_.seeds) * i / kJobs);
    };
    for (uint32_t i = bound(job); i < bound(job + 1) && !context.cancelled; ++i) {
      evaluator.sample(seed_sampler(batch_, size_, i), contribution);
      targets_[i] = contribution.target;
      Explorer::share_independent(share, contribution);
      const auto weight = static_cast<float>(independent_weight());
      for (const Splat& splat : contribution.splats) {
        splats.add(splat.raster, splat.color * weight);
      }
    }
  }

  const PoolSize& size() const { return size_; }
  // The mean target.
  double brightness() const { return sums_.back() / size_.seeds; }
  // What an independent sample's splat counts, in sums over a pixel's samples of the batch.
  double independent_weight() const { return size_.mutations / size_.independents; }
  // The number of the sample that u in [0,1) chooses, in proportion to the targets.
  uint32_t choose(double u) const { return choose_by_sums(sums_, u); }
  double target(uint32_t number) const { return targets_[number]; }
  const SplatFrame& splats() const { return splats_; }

 private:
  static constexpr size_t kJobs = 32;

  void sum() {
    sums_.resize(targets_.size());
    double total = 0.0;
    for (size_t i = 0; i < targets_.size(); ++i) {
      sums_[i] = total += targets_[i];
    }
  }

  const Batch batch_;
  const PoolSize size_;
  std::vector<double> targets_, sums_;
  SplatFrame splats_;
};

}  // namespace vernier
