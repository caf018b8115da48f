// Cellular textures (Worley 1996) as Cycles has them (kernel/svm/voronoi.h): jittered points of a
// lattice in 1 to 4 dimensions, with fractal sums; edges after Quilez 2012.
#pragma once

#include <array>
#include <cstdint>

#include "math/vec.h"

namespace vernier {

// In the order of the node's enum items.
enum class VoronoiFeature : uint8_t { kF1, kF2, kSmoothF1, kDistanceToEdge, kNSphereRadius };
enum class VoronoiMetric : uint8_t { kEuclidean, kManhattan, kChebychev, kMinkowski };

struct VoronoiParams {
  VoronoiFeature feature = VoronoiFeature::kF1;
  VoronoiMetric metric = VoronoiMetric::kEuclidean;
  bool normalize = false;
  float scale = 5.0f;      // coordinates come multiplied by it, positions are divided by it
  float detail = 0.0f;     // [0, 15]
  float roughness = 0.5f;  // [0, 1]
  float lacunarity = 2.0f;
  float smoothness = 0.5f;  // [0, 0.5]: half the socket's value
  float exponent = 0.5f;    // of the Minkowski metric
  float randomness = 1.0f;  // [0, 1]
};

struct VoronoiCell {
  float distance = 0;  // or the radius
  Color color;
  Vec4f position;  // one dimension: in w; two: in x and y
};

// One dimension reads p.w, two read x and y.
VoronoiCell voronoi_texture(int dimensions, Vec4f p, const VoronoiParams& params);

}  // namespace vernier
