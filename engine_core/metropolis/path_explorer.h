// Explores the space of whole paths by mutations (Veach and Guibas 1997).
#pragma once

#include "metropolis/chain_path.h"
#include "metropolis/mutators.h"

namespace vernier {

class PathExplorer {
 public:
  using State = PathState;
  static constexpr bool kIndependentSteps = false;
  static constexpr bool kWholePaths = true;
  // As for the other methods. A mutation costs less than half of an independent sample here.
  static constexpr double kPoolShare = 0.15, kLargeSteps = 0.05;

  PathExplorer(const RenderContext& context, RenderStats& stats)
      : stats_(stats), evaluator_(context, stats, true), space_(context, stats) {}

  void begin_chain(uint64_t number, uint64_t seed) {
    number_ = number;
    frame_seed_ = seed;
    step_ = 0;
  }
  // Starts at one of the paths of an independent sample, in proportion to their targets.
  double start(const SobolSampler& source, Pcg32& rng, MarkovChain<State>& chain);
  void start(Pcg32& rng) { space_.seed(Pcg32(rng.next())); }

  double propose(MarkovChain<State>& chain, bool large);
  void accept() {}
  float random() { return space_.random(); }

  template <class Share>
  static void share_independent(const Share&, Contribution& c) {
    for (Splat& splat : c.splats) {
      splat.color *= splat.target > 0.0 ? 0.0f : 1.0f;
    }
  }

 private:
  // A raster position for the lens sub-path. At every step the chains of a batch cover the frame
  // evenly together, while for each by itself it is uniform and has nothing to do with its path.
  Vec2f stratified_raster();

  RenderStats& stats_;
  PrimaryEvaluator evaluator_;
  PathSpace space_;
  Contribution sample_;
  uint64_t number_ = 0, frame_seed_ = 0, step_ = 0;
};

// The path that a bidirectional tracer has found, as a value. False: by rounding it is none.
bool take_path(PathSpace& space, const FoundPath& found, const BidirectionalMemory& memory,
               Vec2f raster, PathState& path);

}  // namespace vernier
