// What Metropolis methods learn of a scene before the first batch.
#pragma once

#include <array>
#include <cstdint>

#include "bidirectional/plan.h"
#include "metropolis/caustic_guide.h"

namespace vernier {

// How the numbers of a path's vertices are chosen: those that the pilot saw carry light more often,
// and any of them sometimes. Beyond the table they fall off geometrically.
class LengthChoice {
 public:
  static constexpr int kTable = 32;

  LengthChoice() = default;
  // `amounts`: the light that paths of `least`, least + 1, ... vertices carry; those of more than
  // `most` are not chosen.
  LengthChoice(const std::array<double, kTable>& amounts, int least, int most);

  // The length chosen by u in [0,1).
  int sample(float u) const;
  // The probability of a length.
  double probability(int length) const;

 private:
  static constexpr double kFall = 0.8, kTailFall = 0.95;  // from each length to the next

  std::array<double, kTable + 1> cdf_{};  // up to each entry; the last one has the tail
  int least_ = 2;
  bool tail_ = false;
};

// What light is worth to the chains by where it falls in the frame: the more, the darker it is
// around, so that dark parts get as many mutations for their brightness as they need to be as
// accurate as bright ones (Veach 1997, section 11.3.3: two-stage MLT). It is coarse and positive.
class WorthMap {
 public:
  WorthMap() = default;
  // `light`: what a pilot found in cells of the frame, kSide rows of kSide.
  WorthMap(const FilmDesc& film, const std::vector<double>& light);

  static constexpr int kSide = 16;
  static size_t cell(const FilmDesc& film, Vec2f raster);
  float operator()(Vec2f raster) const;
  float at(int x, int y) const {
    return cells_.empty() ? 1.0f : cells_[static_cast<size_t>(y * kSide + x)];
  }

 private:
  Vec2f first_, inverse_size_;
  std::vector<float> cells_;  // empty: 1 everywhere
};

struct MetropolisPlan : BidirectionalPlan {
  // The mean target of a sample, by the pilot: it sets what is left to independent samples, never
  // the picture's brightness. 0: no light was found.
  double scale = 0;
  uint32_t pilot_samples = 0;
  bool chains = true;  // false: all light is left to ordinary samples
  bool black = false;  // there is not even light that these find
  LengthChoice lengths;
  WorthMap worth;
  CausticGuide caustics;

  std::string nothing() const override;
};

// From a pilot of some thousand samples; of many more where these find no light.
std::unique_ptr<const Plan> make_metropolis_plan(const RenderContext& context, uint64_t seed,
                                                 RenderStats& stats);

// Paths of fewer vertices are not the chains' but sampled as a path tracer does.
int least_chain_vertices(const Settings& settings);

}  // namespace vernier
