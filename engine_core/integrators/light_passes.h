// Splits a path's light into the passes of Blender's compositor.
#pragma once

#include <array>

#include "bsdf/bsdf.h"
#include "math/vec.h"
#include "render/film.h"

namespace vernier {

enum LightGroup : int { kGroupDiffuse = 0, kGroupGlossy = 1, kGroupTransmission = 2 };

// The group of a scattering event. Translucency is diffuse, as in Cycles.
inline int light_group(uint8_t lobe) {
  if ((lobe & kLobeDiffuse) != 0) {
    return kGroupDiffuse;
  }
  return (lobe & kLobeTransmission) != 0 ? kGroupTransmission : kGroupGlossy;
}

// Masks that select the events of each group.
inline constexpr std::array<uint8_t, 3> kGroupMasks{
    static_cast<uint8_t>(kLobeDiffuse | kLobeReflection | kLobeTransmission),
    static_cast<uint8_t>(kLobeGlossy | kLobeReflection | kLobeSingular),
    static_cast<uint8_t>(kLobeGlossy | kLobeTransmission | kLobeSingular)};

// Follows one path. What it gathers belongs to the group of its first bounce; where that bounce
// could have been of several groups, to each in proportion.
class LightPasses {
 public:
  explicit LightPasses(PassSample& out) : out_(out) {}

  // The first bounce, toward wi. Singular events belong to one group.
  void first_bounce(const Bsdf& bsdf, const BsdfSample& sample) {
    shares_ = {};
    if ((sample.lobe & kLobeSingular) != 0) {
      shares_[static_cast<size_t>(light_group(sample.lobe))] = splat(1.0f);
      return;
    }
    set_shares(bsdf, sample.wi, kLobeAny);
  }

  // Light sampled at the first vertex.
  void add_first_light(const Bsdf& bsdf, Vec3f wi, uint8_t mask, Color contribution) {
    const std::array<Color, 3> saved = shares_;
    set_shares(bsdf, wi, mask);
    add_to(out_.direct, contribution);
    shares_ = saved;
  }

  // Light met after `bounces` bounces, from a surface or lamp, or from beyond the scene.
  void add_met(int bounces, bool environment, Color contribution) {
    if (bounces == 0) {
      (environment ? out_.environment : out_.emission) += contribution;
    } else {
      add_to(bounces == 1 ? out_.direct : out_.indirect, contribution);
    }
  }

  // Light sampled at a later vertex.
  void add_later_light(Color contribution) { add_to(out_.indirect, contribution); }

 private:
  void set_shares(const Bsdf& bsdf, Vec3f wi, uint8_t mask) {
    std::array<Color, 3> f;
    Color sum;
    for (size_t g = 0; g < 3; ++g) {
      f[g] =
          bsdf.eval_forward(wi, Transport::kRadiance, static_cast<uint8_t>(mask & kGroupMasks[g]))
              .f;
      sum += f[g];
    }
    for (size_t g = 0; g < 3; ++g) {
      for (int c = 0; c < 3; ++c) {
        shares_[g][c] = sum[c] > 0.0f ? f[g][c] / sum[c] : 0.0f;
      }
    }
  }
  void add_to(std::array<Color, 3>& passes, Color contribution) {
    for (size_t g = 0; g < 3; ++g) {
      passes[g] += contribution * shares_[g];
    }
  }

  PassSample& out_;
  std::array<Color, 3> shares_{};
};

}  // namespace vernier
