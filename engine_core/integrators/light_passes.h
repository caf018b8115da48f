// Splits a path's light into the passes of Blender's compositor.
#pragma once

#include <array>

#include "bsdf/bsdf.h"
#include "math/vec.h"
#include "paths/path_vertex.h"
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

// Parts of a light: diffuse, glossy, transmission. They sum to 1, or to 0 where it scatters
// nothing.
using LightShares = std::array<Color, 3>;

// The groups' parts of what `bsdf` scatters between its wo and wi.
inline LightShares light_shares(const Bsdf& bsdf, Vec3f wi, Transport transport, uint8_t mask) {
  LightShares shares;
  Color sum;
  for (size_t g = 0; g < 3; ++g) {
    shares[g] = bsdf.eval_forward(wi, transport, static_cast<uint8_t>(mask & kGroupMasks[g])).f;
    sum += shares[g];
  }
  for (size_t g = 0; g < 3; ++g) {
    for (int c = 0; c < 3; ++c) {
      shares[g][c] = sum[c] > 0.0f ? shares[g][c] / sum[c] : 0.0f;
    }
  }
  return shares;
}

// The groups' parts of what a vertex of a path from a light scatters to the camera, along wi.
inline LightShares shares_toward_camera(const Scene& scene, const PathVertex& v, Vec3f wi) {
  if (!differs_from(v, wi)) {
    return light_shares(v.bsdf, wi, Transport::kImportance, kLobeAny);
  }
  Bsdf seen;
  evaluate_bsdf(scene, seen_from(v.point, wi), seen);
  return light_shares(seen, v.point.wo, Transport::kRadiance, kLobeAny);
}

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
    shares_ = light_shares(bsdf, sample.wi, Transport::kRadiance, kLobeAny);
  }

  // Light that reaches the first vertex from wi: directly from a light, or after other surfaces.
  void add_first_light(const Bsdf& bsdf, Vec3f wi, uint8_t mask, Color contribution,
                       bool direct = true) {
    const LightShares saved = shares_;
    shares_ = light_shares(bsdf, wi, Transport::kRadiance, mask);
    add_to(direct ? out_.direct : out_.indirect, contribution);
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
  void add_to(std::array<Color, 3>& passes, Color contribution) {
    for (size_t g = 0; g < 3; ++g) {
      passes[g] += contribution * shares_[g];
    }
  }

  PassSample& out_;
  LightShares shares_{};
};

}  // namespace vernier
