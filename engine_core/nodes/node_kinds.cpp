#include "nodes/node_kinds.h"

#include <algorithm>

#include "nodes/node_tables.h"

namespace vernier {
namespace {

std::vector<NodeKind> collect() {
  std::vector<NodeKind> all;
  for (auto part : {closure_node_kinds, math_node_kinds, vector_node_kinds, color_node_kinds,
                    input_node_kinds, normal_node_kinds, texture_node_kinds, image_node_kinds}) {
    for (NodeKind& kind : part()) {
      all.push_back(std::move(kind));
    }
  }
  std::sort(all.begin(), all.end(),
            [](const NodeKind& a, const NodeKind& b) { return a.name < b.name; });
  return all;
}

}  // namespace

std::span<const NodeKind> node_kinds() {
  static const std::vector<NodeKind> kinds = collect();
  return kinds;
}

const NodeKind* find_node_kind(std::string_view name) {
  const std::span<const NodeKind> kinds = node_kinds();
  const auto kind =
      std::lower_bound(kinds.begin(), kinds.end(), name,
                       [](const NodeKind& a, std::string_view b) { return a.name < b; });
  return kind != kinds.end() && kind->name == name ? &*kind : nullptr;
}

}  // namespace vernier
