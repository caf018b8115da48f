// A hierarchy over lights by which one is chosen in logarithmic time, in proportion to a bound of
// what it sends to a receiver (Conty Estevez and Kulla 2018, "Importance Sampling of Many Lights
// with Adaptive Tree Splitting"; no splitting: one light per choice).
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
  LightTree() = default;
  // `bounds[i]` are those of light `lights[i]`; intensities are in (0, 1]. The numbers in `lights`
  // are distinct; memory grows with the largest.
  LightTree(std::span<const LightBounds> bounds, std::span<const uint32_t> lights);

  bool empty() const { return nodes_.empty(); }
  // A rough irradiance at the receiver from all lights, 0 where none can reach it.
  float importance(const Receiver& from) const {
    return empty() ? 0.0f : weight(0, static_cast<uint32_t>((nodes_.size() + 1) / 2), from);
  }
  // The light chosen by u in [0,1), and the probability of the choice. Call where importance() is
  // not zero. kNoIndex where what was chosen turns out to reach nothing.
  uint32_t sample(const Receiver& from, double u, float& pdf) const;
  // The probability with which sample() chooses `light`.
  float pdf(const Receiver& from, uint32_t light) const;

 private:
  friend class LightTreeBuilder;
  // In preorder: the left child follows its parent. 48 bytes.
  struct Node {
    Vec3f center, half;           // of the box
    std::array<int16_t, 3> axis;  // in units of 1/32767; the cone holds its rounding
    int16_t cos_o, sin_o, cos_e;
    uint8_t two_sided, is_leaf;
    float intensity;
    uint32_t link;  // inner: the right child; leaf: the light
  };
  static float node_importance(const Node& node, const Receiver& from);
  // What a subtree is chosen in proportion to.
  float weight(uint32_t node, uint32_t leaves, const Receiver& from) const;
  // Probability of the left child; negative where neither reaches the receiver.
  float left_probability(uint32_t node, uint32_t leaves, const Receiver& from) const;

  std::vector<Node> nodes_;
  std::vector<uint32_t> rank_;  // of each light among the leaves
};

}  // namespace vernier
