// A hierarchy over lights by which one is chosen in logarithmic time, in proportion to a bound of
// what it sends to a receiver (Conty Estevez and Kulla 2018, "Importance Sampling of Many Lights
// with Adaptive Tree Splitting"; no splitting: one light per choice). Nodes have eight children,
// side by side in memory, whose importances are computed at once by vector instructions.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lights/light_sample.h"
#include "math/vec.h"

namespace vernier {

// Where a set of lights is, which way it shines and how strongly.
struct LightBounds {
  Vec3f lower{kInfinity, kInfinity, kInfinity};
  Vec3f upper{-kInfinity, -kInfinity, -kInfinity};
  Vec3f axis{0, 0, 1};  // unit; normals lie within angle_o of it and light within angle_e of
  float angle_o = 0;    // a normal; radians
  float angle_e = 0.5f * kPi;
  float intensity = 0;     // largest, per steradian, on a scale common to all lights
  bool two_sided = false;  // shines along minus the normals too
};

LightBounds merge(const LightBounds& a, const LightBounds& b);

// The cosine in a light's importance is at least this: shading normals may be tilted afterwards
// (bump mapping), and a light that a receiver can see must have a chance.
inline constexpr float kImportanceCosineFloor = 0.05f;
// Importances are kept in this range, so that no sum overflows and no light that counts has none.
inline constexpr float kSmallestImportance = 1e-30f, kLargestImportance = 1e30f;

class LightTree {
 public:
  static constexpr int kWidth = 8;

  LightTree() = default;
  // `bounds[i]` are those of light `lights[i]`; intensities are in (0, 1]. The numbers in `lights`
  // are distinct; memory grows with the largest.
  LightTree(std::span<const LightBounds> bounds, std::span<const uint32_t> lights);

  bool empty() const { return nodes_.empty(); }
  // A rough irradiance at the receiver from all lights, 0 where none can reach it.
  float importance(const Receiver& from) const;
  // The light chosen by u in [0,1), and the probability of the choice. kNoIndex where what was
  // chosen turns out to reach nothing.
  uint32_t sample(const Receiver& from, double u, float& pdf) const;
  // The probability with which sample() chooses `light`.
  float pdf(const Receiver& from, uint32_t light) const;

 private:
  friend class LightTreeBuilder;
  using Lanes = std::array<float, kWidth>;

  // Children by component. Unused ones have no intensity.
  struct alignas(32) Node {
    Lanes center_x{}, center_y{}, center_z{};
    Lanes half_x{}, half_y{}, half_z{};  // of the boxes
    Lanes axis_x{}, axis_y{}, axis_z{};
    Lanes cos_o{}, sin_o{}, cos_e{};  // of the cones
    Lanes one_sided{};                // 1: shines along its normals only; 0: both ways
    Lanes intensity{};
    std::array<uint32_t, kWidth> child{};  // a node's number, or a light's
    std::array<bool, kWidth> is_light{};
  };
  // Where a light or node hangs.
  struct Place {
    uint32_t node = kNoIndex;  // kNoIndex: the root, or not in the tree
    uint32_t lane = 0;
  };

  // The importance of every child, and their sum.
  static float weigh(const Node& node, const Receiver& from, Lanes& weights);

  std::vector<Node> nodes_;          // the root first
  std::vector<Place> node_places_;   // of each node
  std::vector<Place> light_places_;  // of each light, by its number
};

}  // namespace vernier
