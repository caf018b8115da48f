// Normal Map, Bump and Tangent: table and lowering.
#include "nodes/math_ops.h"
#include "nodes/node_tables.h"
#include "nodes/normal_ops.h"
#include "nodes/point_ops.h"

namespace vernier {
namespace {

constexpr SocketType kVector = SocketType::kVector;

uint32_t tangent_attribute(NodeLowering& node) {
  return node.context().attribute_id(std::string(kTangentAttributePrefix) +
                                     node.param_string("uv_map"));
}

void lower_normal_map(NodeLowering& node) {
  const auto space = node.param_enum<NormalSpace>("space");
  Value color = node.input("Color");
  enum class Convention { kOpenGl, kDirectX };
  if (node.param_enum<Convention>("convention") == Convention::kDirectX) {
    // DirectX counts green downward.
    const Value keep = node.builder().constant({1, -1, 1, 1}, kVector);
    const Value flip = node.builder().constant({0, 1, 0, 1}, kVector);
    color = node.emit(Op::kVectorMath, VectorMathOp::kMultiplyAdd, kVector,
                      {color, keep, flip, node.builder().constant(1.0f)});
  }
  const uint32_t id = space == NormalSpace::kTangent ? tangent_attribute(node) : 0;
  node.set("Normal",
           node.emit(Op::kNormalMap, space, kVector, {node.input("Strength"), color}, id));
}

// The height is evaluated at three points; at those of another Bump's height this one passes its
// normal on.
void lower_bump(NodeLowering& node) {
  const Value normal = node.input("Normal");
  if (node.point() != 0 || !node.is_linked("Height")) {
    node.set("Normal", normal);
    return;
  }
  ProgramBuilder& builder = node.builder();
  const Value center = node.input_at("Height", node.center_point());
  const Value x = node.input_at("Height", node.shifted_point(ShiftAxis::kX));
  const Value y = node.input_at("Height", node.shifted_point(ShiftAxis::kY));
  if (center.id == x.id && center.id == y.id) {
    node.set("Normal", normal);  // the height is the same everywhere
    return;
  }
  const float sign = node.param_bool("invert") ? -1.0f : 1.0f;
  const Value distance = builder.multiply(node.input("Distance"), builder.constant(sign));
  builder.add_bump_filter(node.constant_input("Filter Width"));
  node.set("Normal", node.emit(Op::kBump, 0, kVector,
                               {node.input("Strength"), distance, center, x, y, normal}));
}

void lower_tangent(NodeLowering& node) {
  enum class Direction { kRadial, kUvMap };
  constexpr uint8_t kByUv = 3;  // after the axes
  if (node.param_enum<Direction>("direction_type") == Direction::kUvMap) {
    node.set("Tangent", node.emit(Op::kTangent, kByUv, kVector, {}, tangent_attribute(node)));
  } else {
    node.set("Tangent", node.emit(Op::kTangent, node.param_enum<TangentAxis>("axis"), kVector, {}));
  }
}

}  // namespace

std::vector<NodeKind> normal_node_kinds() {
  std::vector<NodeKind> kinds;
  kinds.push_back(
      {"ShaderNodeNormalMap",
       NodeRole::kValue,
       lower_normal_map,
       {float_input("Strength", 1.0f), color_input("Color", 0.5f, 0.5f, 1.0f)},
       {vector_output("Normal")},
       {enum_param("space", {"TANGENT", "OBJECT", "WORLD", "BLENDER_OBJECT", "BLENDER_WORLD"}),
        string_param("uv_map"), enum_param("convention", {"OPENGL", "DIRECTX"}),
        enum_param("base", {"DISPLACED", "ORIGINAL"})},
       {}});
  kinds.push_back({"ShaderNodeBump",
                   NodeRole::kValue,
                   lower_bump,
                   {float_input("Strength", 1.0f), float_input("Distance", 1.0f),
                    float_input("Filter Width", 0.1f), float_input("Height", 1.0f),
                    vector_input("Normal", SocketSource::kNormal)},
                   {vector_output("Normal")},
                   {bool_param("invert", false)},
                   {}});
  kinds.push_back({"ShaderNodeTangent",
                   NodeRole::kValue,
                   lower_tangent,
                   {},
                   {vector_output("Tangent")},
                   {enum_param("direction_type", {"RADIAL", "UV_MAP"}),
                    enum_param("axis", {"X", "Y", "Z"}), string_param("uv_map")},
                   {}});
  return kinds;
}

}  // namespace vernier
