#include "nodes/lowering.h"

#include <algorithm>
#include <bit>

namespace vernier {
namespace {

// Index of a point from its bit.
constexpr int kMain = std::countr_zero(static_cast<unsigned>(kPointMain));
constexpr int kCenter = std::countr_zero(static_cast<unsigned>(kPointCenter));
constexpr int kShiftedX = std::countr_zero(static_cast<unsigned>(kPointShiftedX));

// Sockets that Blender keeps on closures for its own use and shows to nobody.
constexpr std::string_view kInternalSocket = "Weight";

Vec4f to_vec4(const std::array<float, 4>& a) { return {a[0], a[1], a[2], a[3]}; }

Vec4f constant_of_type(const std::array<float, 4>& value, SocketType type) {
  return type == SocketType::kFloat ? to_register(value[0]) : to_vec4(value);
}

}  // namespace

GraphLowering::GraphLowering(const Graph& graph, std::string_view material, NodeContext& context)
    : graph_(graph), material_(material), context_(context), outputs_(graph.nodes().size()) {}

Value& GraphLowering::output_slot(uint32_t node, int output, int point) {
  Outputs& values = outputs_[node];
  if (values.empty()) {
    const NodeKind* kind = graph_.nodes()[node].kind;
    values.resize((kind == nullptr ? 1 : kind->outputs.size()) * kPointCount);
  }
  return values[static_cast<size_t>(output * kPointCount + point)];
}

void GraphLowering::run() {
  for (const uint32_t n : graph_.order()) {
    const GraphNode& node = graph_.nodes()[n];
    NodeLowering(*this, n, kMain).report_unknown();
    for (int point = 0; point < kPointCount; ++point) {
      if ((node.points & 1u << point) == 0) {
        continue;
      }
      if (node.kind == nullptr) {
        lower_unknown(n, point);
      } else if (node.kind->role == NodeRole::kValue) {
        NodeLowering lowering(*this, n, point);
        node.kind->lower(lowering);
      }
    }
  }
  lower_closures();
}

// The value of an unknown node is that of its first linked input, if it has one.
void GraphLowering::lower_unknown(uint32_t node, int point) {
  for (const NodeInput& link : graph_.nodes()[node].desc->inputs) {
    if (link.node < 0) {
      continue;
    }
    const auto source = static_cast<uint32_t>(link.node);
    const NodeKind* kind = graph_.nodes()[source].kind;
    const int output = kind == nullptr ? 0 : find_output(*kind, link.output);
    if (output >= 0 && output_slot(source, output, point).exists()) {
      output_slot(node, 0, point) = output_slot(source, output, point);
      return;
    }
  }
}

Value GraphLowering::output(uint32_t node, std::string_view name) {
  const NodeKind* kind = graph_.nodes()[node].kind;
  const int index = kind == nullptr ? 0 : find_output(*kind, name);
  return index < 0 ? Value{} : output_slot(node, index, kMain);
}

// From the surface backward every shader's weight is the sum, over all ways to it, of the product
// of the mix factors on the way: shading is linear in closures.
void GraphLowering::lower_closures() {
  if (graph_.surface() < 0) {
    return;
  }
  const auto surface = static_cast<uint32_t>(graph_.surface());
  std::vector<Value> weights(graph_.nodes().size());
  weights[surface] = builder_.constant(1.0f);

  const auto pass_on = [&](uint32_t node, std::string_view socket, Value weight) {
    const NodeKind& kind = *graph_.nodes()[node].kind;
    for (size_t i = 0; i < kind.inputs.size(); ++i) {
      const NodeInput* link = graph_.input(graph_.nodes()[node], i);
      if (kind.inputs[i].name != socket || link == nullptr || link->node < 0 ||
          builder_.is_constant(weight, 0.0f)) {
        continue;
      }
      Value& total = weights[static_cast<size_t>(link->node)];
      total = total.exists() ? builder_.add(total, weight) : weight;
    }
  };

  const std::vector<uint32_t>& order = graph_.order();
  for (size_t position = order.size(); position-- > 0;) {
    const uint32_t n = order[position];
    const Value weight = weights[n];
    if (!weight.exists() || builder_.is_constant(weight, 0.0f)) {
      continue;
    }
    NodeLowering lowering(*this, n, kMain, weight);
    const NodeKind* kind = graph_.nodes()[n].kind;
    if (kind == nullptr) {
      lowering.add_unknown_closure();
    } else if (kind->role == NodeRole::kClosure) {
      kind->lower(lowering);
    } else if (kind->role == NodeRole::kMixShader) {
      const Value factor =
          builder_.emit(Op::kSaturate, 0, SocketType::kFloat, {lowering.input("Fac")});
      pass_on(n, "Shader", builder_.multiply(weight, builder_.one_minus(factor)));
      pass_on(n, "Shader_001", builder_.multiply(weight, factor));
    } else if (kind->role == NodeRole::kAddShader) {
      pass_on(n, "Shader", weight);
      pass_on(n, "Shader_001", weight);
    } else {
      lowering.add_value_as_emission();
    }
  }
}

void NodeLowering::report_unknown() {
  const GraphNode& node = graph_node();
  if (node.kind == nullptr) {
    warn(
        "this kind of node is not supported; what reads it gets its first linked input, else "
        "the socket's default, and as a shader it is grey diffuse");
    return;
  }
  if (!node.kind->fallback.empty()) {
    warn("not supported; " + std::string(node.kind->fallback));
  }
  for (const NodeInput& input : node.desc->inputs) {
    const bool known = std::any_of(node.kind->inputs.begin(), node.kind->inputs.end(),
                                   [&](const InputKind& k) { return k.name == input.name; });
    if (!known && (input.node >= 0 || input.name != kInternalSocket)) {
      warn("input '" + input.name + "' is not known and is ignored");
    }
  }
  for (const auto& [name, value] : node.desc->params) {
    const bool known = std::any_of(node.kind->params.begin(), node.kind->params.end(),
                                   [&](const ParamKind& k) { return k.name == name; });
    if (!known) {
      warn("parameter '" + name + "' is not known and is ignored");
    }
  }
}

size_t NodeLowering::input_index(std::string_view name) const {
  const std::vector<InputKind>& inputs = kind().inputs;
  size_t index = 0;
  while (index < inputs.size() && inputs[index].name != name) {
    ++index;
  }
  return index;
}

Value NodeLowering::input(std::string_view name) { return input_at(name, point_); }

Value NodeLowering::input_at(std::string_view name, int point) {
  const size_t index = input_index(name);
  const InputKind& input = kind().inputs[index];
  const Value linked = source_value(index, point);
  return linked.exists() ? builder().convert(linked, input.type) : default_value(input, point);
}

Value NodeLowering::linked_input(std::string_view name) {
  return is_linked(name) ? input(name) : Value{};
}

bool NodeLowering::is_linked(std::string_view name) const {
  const NodeInput* link = shared_.graph_.input(graph_node(), input_index(name));
  return link != nullptr && link->node >= 0;
}

float NodeLowering::constant_input(std::string_view name) const {
  const size_t index = input_index(name);
  const NodeInput* given = shared_.graph_.input(graph_node(), index);
  return given != nullptr && given->node < 0 ? given->value[0] : kind().inputs[index].value[0];
}

// The value that an input is linked to; does not exist where it is not, or where what it is linked
// to has no such value (which is told).
Value NodeLowering::source_value(size_t input, int point) {
  const NodeInput* link = shared_.graph_.input(graph_node(), input);
  if (link == nullptr || link->node < 0) {
    return {};
  }
  const auto source = static_cast<uint32_t>(link->node);
  const NodeKind* kind = shared_.graph_.nodes()[source].kind;
  if (kind == nullptr) {
    return shared_.output_slot(source, 0, point);
  }
  const int output = find_output(*kind, link->output);
  if (output < 0) {
    warn("input '" + link->name + "' is linked to an output '" + link->output + "' that " +
         std::string(kind->name) + " does not have; its own value is used");
    return {};
  }
  if (kind->outputs[static_cast<size_t>(output)].type == SocketType::kShader) {
    warn("input '" + link->name + "' is linked to a shader; its own value is used");
    return {};
  }
  return shared_.output_slot(source, output, point);
}

Value NodeLowering::default_value(const InputKind& kind, int point) {
  NodeLowering at(shared_, node_, point);
  switch (kind.source) {
    case SocketSource::kNormal:
      return at.emit(Op::kGeometry, GeometryValue::kNormal, SocketType::kVector, {});
    case SocketSource::kTangent:
      return at.emit(Op::kGeometry, GeometryValue::kTangent, SocketType::kVector, {});
    case SocketSource::kGenerated:
      return at.emit(Op::kGeometry, GeometryValue::kGenerated, SocketType::kVector, {});
    case SocketSource::kPosition:
      return at.emit(Op::kGeometry, GeometryValue::kPosition, SocketType::kVector, {});
    case SocketSource::kUv:
      return at.emit(Op::kAttribute, AttributeUse::kVector, SocketType::kVector, {},
                     context().attribute_id(kActiveUvAttribute));
    case SocketSource::kValue:
      break;
  }
  const NodeInput* given = shared_.graph_.input(graph_node(), input_index(kind.name));
  const bool has_value = given != nullptr && given->node < 0;
  return builder().constant(constant_of_type(has_value ? given->value : kind.value, kind.type),
                            kind.type);
}

bool NodeLowering::wants(std::string_view output) const {
  const int index = find_output(kind(), output);
  return index >= 0 && (graph_node().outputs & uint64_t{1} << index) != 0;
}

void NodeLowering::set(std::string_view output, Value value) {
  const int index = find_output(kind(), output);
  const SocketType type = kind().outputs[static_cast<size_t>(index)].type;
  shared_.output_slot(node_, index, point_) = {value.id, type};
}

const ParamKind& NodeLowering::param_kind(std::string_view name) const {
  return *std::find_if(kind().params.begin(), kind().params.end(),
                       [&](const ParamKind& param) { return param.name == name; });
}

const ParamValue* NodeLowering::param(std::string_view name) const {
  const auto& params = graph_node().desc->params;
  const auto entry = params.find(std::string(name));
  return entry == params.end() ? nullptr : &entry->second;
}

float NodeLowering::param_float(std::string_view name) {
  const ParamValue* value = param(name);
  if (value != nullptr) {
    if (const auto* number = std::get_if<double>(value)) {
      return static_cast<float>(*number);
    }
    if (const auto* number = std::get_if<int64_t>(value)) {
      return static_cast<float>(*number);
    }
    if (const auto* number = std::get_if<bool>(value)) {
      return *number ? 1.0f : 0.0f;
    }
    warn("parameter '" + std::string(name) + "' is not a number; its default is used");
  }
  return static_cast<float>(param_kind(name).number);
}

bool NodeLowering::param_bool(std::string_view name) { return param_float(name) != 0.0f; }

int NodeLowering::param_int(std::string_view name) {
  return static_cast<int>(clamp(param_float(name), -1e9f, 1e9f));
}

std::string NodeLowering::param_string(std::string_view name) {
  const ParamValue* value = param(name);
  const auto* text = value == nullptr ? nullptr : std::get_if<std::string>(value);
  return text == nullptr ? std::string() : *text;
}

std::vector<float> NodeLowering::param_floats(std::string_view name) {
  const ParamValue* value = param(name);
  const auto* floats = value == nullptr ? nullptr : std::get_if<std::vector<float>>(value);
  return floats == nullptr ? std::vector<float>() : *floats;
}

int NodeLowering::param_item(std::string_view name) {
  const ParamKind& kind = param_kind(name);
  const std::string given = param_string(name);
  if (given.empty()) {
    return 0;
  }
  for (size_t i = 0; i < kind.items.size(); ++i) {
    if (kind.items[i] == given) {
      return static_cast<int>(i);
    }
  }
  warn("'" + given + "' of parameter '" + std::string(name) + "' is not known; " +
       std::string(kind.items.front()) + " is used");
  return 0;
}

void NodeLowering::warn(const std::string& message) {
  const NodeDesc& desc = *graph_node().desc;
  context().warn("material '" + std::string(shared_.material_) + "', node '" + desc.name + "' (" +
                 desc.kind + "): " + message);
}

EvaluationPoint NodeLowering::evaluation_point() const {
  if (point_ < kShiftedX) {
    return EvaluationPoint::kMain;
  }
  return point_ == kShiftedX ? EvaluationPoint::kShiftedX : EvaluationPoint::kShiftedY;
}

int NodeLowering::center_point() const {
  const size_t height = input_index("Height");
  const uint8_t points = shared_.graph_.source_points(graph_node(), height, kPointMain);
  return (points & kPointCenter) != 0 ? kCenter : kMain;
}

int NodeLowering::shifted_point(ShiftAxis axis) {
  return axis == ShiftAxis::kX ? kShiftedX : kShiftedX + 1;
}

void NodeLowering::add_closure(ClosureKind kind, std::vector<Value> parameters, bool has_normal,
                               Distribution distribution, bool option) {
  PendingClosure closure;
  closure.code.kind = kind;
  closure.code.distribution = distribution;
  closure.code.option = option;
  closure.weight = weight_;
  if (has_normal) {
    closure.normal = linked_input("Normal");
  }
  closure.parameters = std::move(parameters);
  shared_.closures_.push_back(std::move(closure));
}

// Blender lets any value be linked to a shader socket: it is emitted.
void NodeLowering::add_value_as_emission() {
  for (size_t i = 0; i < kind().outputs.size(); ++i) {
    const Value value = shared_.output_slot(node_, static_cast<int>(i), kMain);
    if ((graph_node().outputs & uint64_t{1} << i) != 0 && value.exists()) {
      add_closure(ClosureKind::kEmission,
                  {builder().convert(value, SocketType::kColor), builder().constant(1.0f)}, false);
      return;
    }
  }
}

void NodeLowering::add_unknown_closure() {
  const Value grey = builder().constant({0.8f, 0.8f, 0.8f, 1.0f}, SocketType::kColor);
  add_closure(ClosureKind::kDiffuse, {grey, builder().constant(0.0f)}, false);
}

}  // namespace vernier
