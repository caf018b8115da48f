// Names of the sampler's dimensions.
//
// Every random decision of a path has its own pair of dimensions, so that a decision that is not
// made leaves the others stratified, and an edit to one technique does not disturb another.
#pragma once

#include <cstdint>

namespace vernier {

enum class CameraDim : uint32_t { kFilter = 0, kLens = 1, kCount = 2 };

// Pairs that each vertex of a path owns.
enum class BounceDim : uint32_t {
  kDirection = 0,    // the point within the lobe
  kLobe = 1,         // x: which lobe; y: Russian roulette
  kLightPoint = 2,   // the point on the light
  kLightChoice = 3,  // x: which light; y: which estimator, where there is a choice; from lights:
                     // of which kind the bounce is
  kJoin = 4,         // which vertices of the other end a vertex is joined to
  kCount = 5,
};

// Pairs of the start of a path that leaves a light.
enum class LightDim : uint32_t {
  kChoice = 0,     // x: which light; y: whether there is a path
  kPosition = 1,   // the point on it
  kDirection = 2,  // the direction
  kCount = 3,
};

// Paths from lights number their dimensions from here, beyond those of any path from the camera.
inline constexpr uint32_t kFirstLightDimension = 1u << 30;

constexpr uint32_t dimension(LightDim d) { return kFirstLightDimension + static_cast<uint32_t>(d); }
constexpr uint32_t dimension(CameraDim d) { return static_cast<uint32_t>(d); }
constexpr uint32_t dimension(uint32_t bounce, BounceDim d) {
  return static_cast<uint32_t>(CameraDim::kCount) +
         bounce * static_cast<uint32_t>(BounceDim::kCount) + static_cast<uint32_t>(d);
}
// The same for a path from a light.
constexpr uint32_t light_dimension(uint32_t bounce, BounceDim d) {
  return kFirstLightDimension + static_cast<uint32_t>(LightDim::kCount) +
         bounce * static_cast<uint32_t>(BounceDim::kCount) + static_cast<uint32_t>(d);
}

}  // namespace vernier
