// What the description of a node kind uses to turn one node into instructions.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "nodes/builder.h"
#include "nodes/closures.h"
#include "nodes/graph.h"
#include "nodes/material.h"
#include "nodes/point_ops.h"

namespace vernier {

// A closure before linking: values in place of operands.
struct PendingClosure {
  ClosureCode code;
  Value weight;
  Value normal;  // does not exist: the shading normal
  std::vector<Value> parameters;
};

// The state of one compilation that its nodes share.
class GraphLowering {
 public:
  GraphLowering(const Graph& graph, std::string_view material, NodeContext& context);

  // Emits everything; afterwards closures() are the surface.
  void run();

  ProgramBuilder& builder() { return builder_; }
  const std::vector<PendingClosure>& closures() const { return closures_; }
  // The value that the surface socket reads, where it is linked to a value and not to a shader.
  Value output(uint32_t node, std::string_view name);

 private:
  friend class NodeLowering;

  // Values of a node's outputs at each of the points; sized on first use.
  using Outputs = std::vector<Value>;

  void lower_unknown(uint32_t node, int point);
  void lower_closures();
  Value& output_slot(uint32_t node, int output, int point);

  const Graph& graph_;
  std::string_view material_;
  NodeContext& context_;
  ProgramBuilder builder_;
  std::vector<Outputs> outputs_;
  std::vector<PendingClosure> closures_;
};

// One node at one point.
class NodeLowering {
 public:
  NodeLowering(GraphLowering& shared, uint32_t node, int point, Value weight = {})
      : shared_(shared), node_(node), point_(point), weight_(weight) {}

  const NodeKind& kind() const { return *graph_node().kind; }
  ProgramBuilder& builder() { return shared_.builder_; }
  NodeContext& context() { return shared_.context_; }

  // The value of an input, converted to its type; `type` overrides the declared one.
  Value input(std::string_view name);
  // The same at another of the points (for height maps).
  Value input_at(std::string_view name, int point);
  // Does not exist where the input is not linked.
  Value linked_input(std::string_view name);
  bool is_linked(std::string_view name) const;
  // The constant that an unlinked input gives, or the kind's default.
  float constant_input(std::string_view name) const;

  bool wants(std::string_view output) const;
  void set(std::string_view output, Value value);

  // Parameters, their kind's default where the node gives none.
  bool param_bool(std::string_view name);
  int param_int(std::string_view name);
  float param_float(std::string_view name);
  std::string param_string(std::string_view name);
  std::vector<float> param_floats(std::string_view name);
  // Index of the item among the kind's; unknown items warn and give the default.
  template <typename Enum>
  Enum param_enum(std::string_view name) {
    return static_cast<Enum>(param_item(name));
  }

  // "material 'x', node 'y' (kind): " + message, as a warning to the user.
  void warn(const std::string& message);

  // Emits at this node's point.
  template <typename Variant>
  Value emit(Op op, Variant variant, SocketType type, std::initializer_list<Value> operands,
             uint32_t data = 0) {
    return builder().emit(op, variant, type, operands, data, evaluation_point());
  }
  EvaluationPoint evaluation_point() const;
  int point() const { return point_; }
  // The point at which the undisturbed height is taken.
  int center_point() const;
  static int shifted_point(ShiftAxis axis);

  // Closures: the weight of this node in the mix, and the addition of one closure.
  Value weight() const { return weight_; }
  void add_closure(ClosureKind kind, std::vector<Value> parameters, bool has_normal,
                   Distribution distribution = Distribution::kGgx, bool option = false);
  void add_value_as_emission();
  void add_unknown_closure();

  // Warns of what this node has that the core does not know.
  void report_unknown();

 private:
  const GraphNode& graph_node() const { return shared_.graph_.nodes()[node_]; }
  size_t input_index(std::string_view name) const;
  const ParamKind& param_kind(std::string_view name) const;
  const ParamValue* param(std::string_view name) const;
  int param_item(std::string_view name);
  Value source_value(size_t input, int point);
  Value default_value(const InputKind& kind, int point);

  GraphLowering& shared_;
  uint32_t node_;
  int point_;
  Value weight_;
};

}  // namespace vernier
