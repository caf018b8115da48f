#include "nodes/graph.h"

#include <stdexcept>
#include <string>
#include <unordered_map>

namespace vernier {
namespace {

constexpr std::string_view kBump = "ShaderNodeBump";

std::string quoted(std::string_view text) { return "'" + std::string(text) + "'"; }

std::string describe(std::string_view material, const NodeDesc& node) {
  return "material " + quoted(material) + ", node " + quoted(node.name) + " (" + node.kind + ")";
}

// Where one side of a Mix Shader with a constant factor is never seen, the input of that side.
int unseen_side(const GraphNode& node) {
  constexpr size_t kFactor = 0;
  if (node.kind->role != NodeRole::kMixShader) {
    return -1;
  }
  float factor = node.kind->inputs[kFactor].value[0];
  if (const int given = node.inputs[kFactor]; given >= 0) {
    const NodeInput& input = node.desc->inputs[static_cast<size_t>(given)];
    if (input.node >= 0) {
      return -1;
    }
    factor = input.value[0];
  }
  return factor >= 1.0f ? 1 : (factor <= 0.0f ? 2 : -1);
}

}  // namespace

int find_output(const NodeKind& kind, std::string_view name) {
  for (size_t i = 0; i < kind.outputs.size(); ++i) {
    if (kind.outputs[i].name == name) {
      return static_cast<int>(i);
    }
  }
  return -1;
}

Graph::Graph(const GraphDesc& desc, std::string_view material) : desc_(desc) {
  check_links(material);
  surface_ = desc.surface.node;
  nodes_.resize(desc.nodes.size());
  for (size_t n = 0; n < nodes_.size(); ++n) {
    GraphNode& node = nodes_[n];
    node.desc = &desc.nodes[n];
    node.kind = find_node_kind(node.desc->kind);
    if (node.kind == nullptr) {
      continue;
    }
    node.inputs.assign(node.kind->inputs.size(), -1);
    for (size_t i = 0; i < node.desc->inputs.size(); ++i) {
      for (size_t k = 0; k < node.inputs.size(); ++k) {
        if (node.kind->inputs[k].name == node.desc->inputs[i].name) {
          node.inputs[k] = static_cast<int>(i);
        }
      }
    }
  }
  sort(material);
  propagate_needs();
}

void Graph::check_links(std::string_view material) const {
  const auto count = static_cast<int64_t>(desc_.nodes.size());
  if (desc_.surface.node < -1 || desc_.surface.node >= count) {
    throw std::invalid_argument("material " + quoted(material) + ": the surface is node " +
                                std::to_string(desc_.surface.node) + " of " +
                                std::to_string(count));
  }
  for (const NodeDesc& node : desc_.nodes) {
    for (const NodeInput& input : node.inputs) {
      if (input.node < -1 || input.node >= count) {
        throw std::invalid_argument(describe(material, node) + ": input " + quoted(input.name) +
                                    " is linked to node " + std::to_string(input.node) + " of " +
                                    std::to_string(count));
      }
    }
  }
}

// Depth first with a stack of its own: graphs may be deeper than the machine's stack. All nodes are
// visited, so that a cycle is found even where nothing reads it.
void Graph::sort(std::string_view material) {
  enum class Mark : uint8_t { kNew, kOpen, kDone };
  struct Visit {
    uint32_t node;
    size_t next_input;
  };
  std::vector<Mark> marks(nodes_.size(), Mark::kNew);
  std::vector<Visit> stack;
  order_.reserve(nodes_.size());
  for (uint32_t root = 0; root < nodes_.size(); ++root) {
    if (marks[root] != Mark::kNew) {
      continue;
    }
    marks[root] = Mark::kOpen;
    stack.push_back({root, 0});
    while (!stack.empty()) {
      Visit& visit = stack.back();
      const std::vector<NodeInput>& inputs = desc_.nodes[visit.node].inputs;
      if (visit.next_input == inputs.size()) {
        marks[visit.node] = Mark::kDone;
        order_.push_back(visit.node);
        stack.pop_back();
        continue;
      }
      const int32_t source = inputs[visit.next_input++].node;
      if (source < 0 || marks[static_cast<size_t>(source)] == Mark::kDone) {
        continue;
      }
      if (marks[static_cast<size_t>(source)] == Mark::kOpen) {
        throw std::invalid_argument(describe(material, desc_.nodes[static_cast<size_t>(source)]) +
                                    ": its links form a cycle");
      }
      marks[static_cast<size_t>(source)] = Mark::kOpen;
      stack.push_back({static_cast<uint32_t>(source), 0});
    }
  }
  for (const uint32_t n : order_) {
    GraphNode& node = nodes_[n];
    node.contains_bump = node.desc->kind == kBump;
    for (const NodeInput& input : node.desc->inputs) {
      node.contains_bump =
          node.contains_bump ||
          (input.node >= 0 && nodes_[static_cast<size_t>(input.node)].contains_bump);
    }
  }
}

const NodeInput* Graph::input(const GraphNode& node, size_t input) const {
  const int index = node.inputs[input];
  return index < 0 ? nullptr : &node.desc->inputs[static_cast<size_t>(index)];
}

uint8_t Graph::source_points(const GraphNode& node, size_t input, uint8_t points) const {
  if (node.desc->kind != kBump) {
    return points;
  }
  const std::string_view name = node.kind->inputs[input].name;
  const bool main = (points & kPointMain) != 0;
  if (name == "Height") {
    const NodeInput* link = this->input(node, input);
    const bool nested =
        link != nullptr && link->node >= 0 && nodes_[static_cast<size_t>(link->node)].contains_bump;
    const uint8_t center = nested ? kPointCenter : kPointMain;
    return main ? static_cast<uint8_t>(center | kPointShiftedX | kPointShiftedY) : uint8_t{0};
  }
  return name == "Normal" ? points : static_cast<uint8_t>(points & kPointMain);
}

// From the surface backward: what is needed, where, and which outputs. Then order() keeps only
// that.
void Graph::propagate_needs() {
  if (surface_ >= 0) {
    GraphNode& root = nodes_[static_cast<size_t>(surface_)];
    root.points = kPointMain;
    if (root.kind != nullptr) {
      const int output = find_output(*root.kind, desc_.surface.output);
      root.outputs |= output >= 0 ? uint64_t{1} << output : 0;
    }
  }
  for (size_t position = order_.size(); position-- > 0;) {
    const GraphNode& node = nodes_[order_[position]];
    if (node.points == 0) {
      continue;
    }
    const auto need = [&](const NodeInput& link, uint8_t points) {
      if (link.node < 0 || points == 0) {
        return;
      }
      GraphNode& source = nodes_[static_cast<size_t>(link.node)];
      source.points |= points;
      if (source.kind != nullptr) {
        const int output = find_output(*source.kind, link.output);
        source.outputs |= output >= 0 ? uint64_t{1} << output : 0;
      }
    };
    if (node.kind == nullptr) {
      for (const NodeInput& link : node.desc->inputs) {
        need(link, node.points);
      }
      continue;
    }
    const int unseen = unseen_side(node);
    for (size_t i = 0; i < node.inputs.size(); ++i) {
      const NodeInput* link = input(node, i);
      if (link != nullptr && static_cast<int>(i) != unseen) {
        need(*link, source_points(node, i, node.points));
      }
    }
  }
  std::erase_if(order_, [this](uint32_t n) { return nodes_[n].points == 0; });
}

}  // namespace vernier
