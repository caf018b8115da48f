// Which lobes gather photons, and which are followed by rays.
#pragma once

#include <cstdint>

#include "bsdf/bsdf.h"

namespace vernier {

// Glossy lobes as rough as this (alpha of 0.25) gather photons: sharper ones point at too few of
// them, and rays find what they reflect. The squared roughness, alpha_x alpha_y.
inline constexpr float kGatherRoughness = 0.0625f;

// The lobes through which a surface shows its photons: the diffuse ones, and the glossy ones where
// none of them is sharp. 0: there are none. The rest is specular in the sense of Jensen (2001):
// paths of light from there on are caustics, and the eye's rays are traced on.
inline uint8_t gathered_lobes(const Bsdf& bsdf) {
  constexpr uint8_t kDirections = kLobeReflection | kLobeTransmission;
  const uint8_t bits = bsdf.lobes();
  const bool rough = (bits & kLobeGlossy) != 0 && bsdf.sharpest_glossy() >= kGatherRoughness;
  if ((bits & kLobeDiffuse) == 0 && !rough) {
    return 0;
  }
  return static_cast<uint8_t>(kDirections | kLobeDiffuse | (rough ? kLobeGlossy : 0));
}

// The lobes that are followed: all others. (Where glossy lobes gather, none is singular.)
inline uint8_t followed_lobes(uint8_t gathered) {
  constexpr uint8_t kStraight = kLobeSingular | kLobeTransparent;
  if ((gathered & kLobeGlossy) != 0) {
    return kStraight;
  }
  return static_cast<uint8_t>(kStraight | kLobeGlossy | kLobeReflection | kLobeTransmission);
}

}  // namespace vernier
