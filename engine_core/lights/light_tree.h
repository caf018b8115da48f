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
#include "math/lanes.h"
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
// And an importance at least this: no light that counts has none.
inline constexpr float kSmallestImportance = 1e-30f;

class LightTree {
 public:
  static constexpr int kWidth = 8;

  LightTree() = default;
  // `bounds[i]` are those of light `lights[i]`; intensities are in (0, 1]. The numbers in `lights`
  // are distinct; memory grows with the largest.
  LightTree(std::span<const LightBounds> bounds, std::span<const uint32_t> lights);

  bool empty() const { return nodes_.empty(); }

  // What is asked for a receiver, of all children of a node alike.
  struct Query {
    explicit Query(const Receiver& from);

    std::array<float, kWidth> p_x, p_y, p_z, ng_x, ng_y, ng_z, ns_x, ns_y, ns_z;
    std::array<float, kWidth> lowest;    // what is higher may be above the receiver's plane
    std::array<uint32_t, kWidth> sides;  // bits to keep of cosines: not the sign if either counts
  };
  // A choice among the children of a node.
  struct Choice {
    // Each child has the part of [0, sum) from the end of the one before to its own: float32 may
    // have moved the ends, but what is drawn has the very probability that is told of it. Before
    // the first is a zero.
    std::array<Floats4, 1 + kWidth / 4> ends{};

    float begin(size_t i) const { return ends[(i + 3) / 4][(i + 3) % 4]; }
    float end(size_t i) const { return begin(i + 1); }
    // A rough irradiance at the receiver, 0 where no light can reach it.
    float sum() const { return end(kWidth - 1); }
  };
  // The choice that all others for this receiver begin with.
  Choice choose_first(const Query& from) const;
  // The light chosen by u in [0,1), and the probability of the choice. kNoIndex where what was
  // chosen turns out to reach nothing.
  uint32_t sample(const Query& from, const Choice& first, double u, float& pdf) const;
  // The probability with which sample() chooses `light`.
  float pdf(const Query& from, const Choice& first, uint32_t light) const;

 private:
  friend class LightTreeBuilder;
  template <class T>
  using Children = std::array<T, kWidth>;

  static constexpr float kLarge = 1e30f;
  static constexpr uint32_t kSign = 0x80000000u, kIsLight = 0x80000000u;

  // Children by component, in four cache lines: trees are larger than caches. Two numbers share a
  // word: the first is all of it, as a float32, whatever the second makes of its lower bits; the
  // second is a float32 of which the lower half is left out.
  struct alignas(64) Node {
    Children<float> center_x{}, center_y{}, center_z{};  // of the spheres about the lights
    // Their radii, with what rounding may move. And the cosines of angle_e; unused children shine
    // at no angle.
    Children<uint32_t> radius_cos_e = unused();
    // Minus the axes of the cones, not of unit length, and the cosines and sines of angle_o over
    // that length. Negative intensities: those that shine both ways.
    Children<uint32_t> axis_x_cos_o{}, axis_y_sin_o{}, axis_z_intensity{};
    // A node's number, or a light's and kIsLight; kNoIndex: unused, which a receiver at a place
    // that is no number may choose.
    Children<uint32_t> child = none();

    static Children<uint32_t> none() {
      Children<uint32_t> children;
      children.fill(kNoIndex);
      return children;
    }
    static Children<uint32_t> unused() {
      constexpr uint32_t kOneAndTwo = 0x3f804000u;  // a radius of one, a cosine of two
      Children<uint32_t> words;
      words.fill(kOneAndTwo);
      return words;
    }
  };
  // Where a light or node hangs.
  struct Place {
    uint32_t node = kNoIndex;  // kNoIndex: the root, or not in the tree
    uint32_t lane = 0;
  };

  static Choice weigh(const Node& node, const Query& from);

  std::vector<Node> nodes_;          // the root first
  std::vector<Place> node_places_;   // of each node
  std::vector<Place> light_places_;  // of each light, by its number
};

}  // namespace vernier
