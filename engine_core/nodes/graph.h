// A node graph whose links have been checked, in an order in which it can be compiled.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "nodes/node_kinds.h"
#include "scene/description.h"

namespace vernier {

// Bits of the points at which a node's value is needed. Height maps are evaluated at the neighbours
// too, and at the centre as it is without further bumps: there a Bump node passes its normal on.
enum PointBits : uint8_t {
  kPointMain = 1u << 0,
  kPointCenter = 1u << 1,
  kPointShiftedX = 1u << 2,
  kPointShiftedY = 1u << 3,
};
inline constexpr int kPointCount = 4;

struct GraphNode {
  const NodeKind* kind = nullptr;  // null: unknown
  const NodeDesc* desc = nullptr;
  std::vector<int> inputs;     // of each of the kind's inputs, its index in desc->inputs or -1
  uint8_t points = 0;          // PointBits where the node is needed; 0: dead
  uint64_t outputs = 0;        // bits of the kind's outputs that are read
  bool contains_bump = false;  // it is a Bump node, or depends on one
};

class Graph {
 public:
  // Throws std::invalid_argument naming the material, and the node, for a link out of range or a
  // cycle. The description must outlive the graph.
  Graph(const GraphDesc& desc, std::string_view material);

  const std::vector<GraphNode>& nodes() const { return nodes_; }
  // Live nodes, each after those that it depends on.
  const std::vector<uint32_t>& order() const { return order_; }
  // The node that is the surface, or -1.
  int surface() const { return surface_; }

  // The link of input number `input` of a node's kind; node -1 where it is not linked.
  const NodeInput* input(const GraphNode& node, size_t input) const;
  // Where the points of a node's own evaluation need the source of its input `input`.
  uint8_t source_points(const GraphNode& node, size_t input, uint8_t points) const;

 private:
  void check_links(std::string_view material) const;
  void sort(std::string_view material);
  void propagate_needs();

  const GraphDesc& desc_;
  std::vector<GraphNode> nodes_;
  std::vector<uint32_t> order_;
  int surface_ = -1;
};

// Index of a kind's output by name; -1 where it has none of that name.
int find_output(const NodeKind& kind, std::string_view name);

}  // namespace vernier
