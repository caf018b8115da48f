// The light pass of photon methods: one or two maps, made anew for every batch.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "integrators/integrator.h"
#include "lights/emission_guide.h"
#include "photons/photon_map.h"

namespace vernier {

// How a map is filled.
struct PhotonOrder {
  const EmissionGuide* guide = nullptr;  // which paths start; it outlives the pass
  uint8_t kinds = 0;                     // of photons that are stored
  uint64_t paths = 0;                    // to start with
  // While there are fewer photons than these, more paths start, up to `most_paths`. The number of
  // paths must not hang on what they find, or the estimate is biased: `paths` is meant to do.
  uint64_t least = 0, most_paths = 0;
};

class PhotonPass : public LightPass {
 public:
  PhotonPass(const std::vector<PhotonOrder>& orders, const Batch& batch);

  int stages() const override;
  size_t jobs(int stage) const override;
  void run(int stage, size_t job, const RenderContext& context, RenderStats& stats) override;

  // Of order i; complete when all stages are done.
  const PhotonMap& map(size_t i) const { return makings_[i]->map; }

 private:
  // Rounds of paths for a map, at most: the first nearly always does.
  static constexpr int kRounds = 4;

  struct Making {
    PhotonOrder order;
    uint64_t seed = 0;
    std::vector<PhotonChunk> chunks;
    uint64_t before = 0;  // paths of earlier rounds
    uint64_t paths = 0;   // of this round
    PhotonMap map;
    PhotonMapBuild build{map, chunks};
  };

  // A stage is the start of a round, the round, or a part of the map's making.
  int stages_of_map() const { return 2 * kRounds + makings_.front()->build.stages(); }
  void begin_round(Making& making, int round);
  void trace(Making& making, int round, size_t job, const RenderContext& context,
             RenderStats& stats);

  std::vector<std::unique_ptr<Making>> makings_;
};

}  // namespace vernier
