// Math, Vector Math, Clamp, Map Range, Mix of numbers: table and lowering.
#include "nodes/math_ops.h"
#include "nodes/node_tables.h"

namespace vernier {
namespace {

constexpr SocketType kFloat = SocketType::kFloat;
constexpr SocketType kVector = SocketType::kVector;

void lower_math(NodeLowering& node) {
  Value value = node.emit(Op::kMath, node.param_enum<MathOp>("operation"), kFloat,
                          {node.input("Value"), node.input("Value_001"), node.input("Value_002")});
  if (node.param_bool("use_clamp")) {
    value = node.emit(Op::kSaturate, 0, kFloat, {value});
  }
  node.set("Value", value);
}

void lower_vector_math(NodeLowering& node) {
  const auto op = node.param_enum<VectorMathOp>("operation");
  const Value a = node.input("Vector"), b = node.input("Vector_001");
  const Value zero = node.builder().constant(0.0f);
  node.set("Value", is_scalar(op) ? node.emit(Op::kVectorMathValue, op, kFloat, {a, b}) : zero);
  node.set("Vector", is_scalar(op)
                         ? zero
                         : node.emit(Op::kVectorMath, op, kVector,
                                     {a, b, node.input("Vector_002"), node.input("Scale")}));
}

void lower_clamp(NodeLowering& node) {
  node.set("Result", node.emit(Op::kClamp, node.param_enum<ClampKind>("clamp_type"), kFloat,
                               {node.input("Value"), node.input("Min"), node.input("Max")}));
}

void lower_map_range(NodeLowering& node) {
  const auto kind = node.param_enum<MapRangeKind>("interpolation_type");
  // Smooth steps do not leave the range.
  const bool clamps =
      node.param_bool("clamp") && (kind == MapRangeKind::kLinear || kind == MapRangeKind::kStepped);
  enum class DataType { kNumbers, kVectors };
  if (node.param_enum<DataType>("data_type") == DataType::kNumbers) {
    const Value lo = node.input("To Min"), hi = node.input("To Max");
    Value value = node.emit(Op::kMapRange, kind, kFloat,
                            {node.input("Value"), node.input("From Min"), node.input("From Max"),
                             lo, hi, node.input("Steps")});
    if (clamps) {
      value = node.emit(Op::kClampBetween, 0, kFloat, {value, lo, hi});
    }
    node.set("Result", value);
    node.set("Vector", node.builder().constant(0.0f));
    return;
  }
  const Value lo = node.input("To_Min_FLOAT3"), hi = node.input("To_Max_FLOAT3");
  Value value = node.emit(Op::kMapRangeVector, kind, kVector,
                          {node.input("Vector"), node.input("From_Min_FLOAT3"),
                           node.input("From_Max_FLOAT3"), lo, hi, node.input("Steps_FLOAT3")});
  if (clamps) {
    value = node.emit(Op::kClampBetween, 0, kVector, {value, lo, hi});
  }
  node.set("Vector", value);
  node.set("Result", node.builder().constant(0.0f));
}

void lower_value(NodeLowering& node) {
  node.set("Value", node.builder().constant(node.param_float("value")));
}

}  // namespace

std::vector<NodeKind> math_node_kinds() {
  std::vector<NodeKind> kinds;
  kinds.push_back(
      {"ShaderNodeMath",
       NodeRole::kValue,
       lower_math,
       {float_input("Value", 0.5f), float_input("Value_001", 0.5f), float_input("Value_002", 0.5f)},
       {float_output("Value")},
       {enum_param("operation", {"ADD",          "SUBTRACT",       "MULTIPLY",     "DIVIDE",
                                 "MULTIPLY_ADD", "POWER",          "LOGARITHM",    "SQRT",
                                 "INVERSE_SQRT", "ABSOLUTE",       "EXPONENT",     "MINIMUM",
                                 "MAXIMUM",      "LESS_THAN",      "GREATER_THAN", "SIGN",
                                 "COMPARE",      "SMOOTH_MIN",     "SMOOTH_MAX",   "ROUND",
                                 "FLOOR",        "CEIL",           "TRUNC",        "FRACT",
                                 "MODULO",       "FLOORED_MODULO", "WRAP",         "SNAP",
                                 "PINGPONG",     "SINE",           "COSINE",       "TANGENT",
                                 "ARCSINE",      "ARCCOSINE",      "ARCTANGENT",   "ARCTAN2",
                                 "SINH",         "COSH",           "TANH",         "RADIANS",
                                 "DEGREES"}),
        bool_param("use_clamp", false)},
       {}});
  kinds.push_back({"ShaderNodeVectorMath",
                   NodeRole::kValue,
                   lower_vector_math,
                   {vector_input("Vector"), vector_input("Vector_001"), vector_input("Vector_002"),
                    float_input("Scale", 1.0f)},
                   {vector_output("Vector"), float_output("Value")},
                   {enum_param("operation",
                               {"ADD",           "SUBTRACT", "MULTIPLY", "DIVIDE",   "MULTIPLY_ADD",
                                "CROSS_PRODUCT", "PROJECT",  "REFLECT",  "REFRACT",  "FACEFORWARD",
                                "DOT_PRODUCT",   "DISTANCE", "LENGTH",   "SCALE",    "NORMALIZE",
                                "ABSOLUTE",      "POWER",    "SIGN",     "MINIMUM",  "MAXIMUM",
                                "ROUND",         "FLOOR",    "CEIL",     "FRACTION", "MODULO",
                                "WRAP",          "SNAP",     "SINE",     "COSINE",   "TANGENT"})},
                   {}});
  kinds.push_back({"ShaderNodeClamp",
                   NodeRole::kValue,
                   lower_clamp,
                   {float_input("Value", 1.0f), float_input("Min", 0.0f), float_input("Max", 1.0f)},
                   {float_output("Result")},
                   {enum_param("clamp_type", {"MINMAX", "RANGE"})},
                   {}});
  kinds.push_back(
      {"ShaderNodeMapRange",
       NodeRole::kValue,
       lower_map_range,
       {float_input("Value", 1.0f), float_input("From Min", 0.0f), float_input("From Max", 1.0f),
        float_input("To Min", 0.0f), float_input("To Max", 1.0f), float_input("Steps", 4.0f),
        vector_input("Vector"), vector_input("From_Min_FLOAT3"),
        vector_input("From_Max_FLOAT3", 1, 1, 1), vector_input("To_Min_FLOAT3"),
        vector_input("To_Max_FLOAT3", 1, 1, 1), vector_input("Steps_FLOAT3", 4, 4, 4)},
       {float_output("Result"), vector_output("Vector")},
       {enum_param("interpolation_type", {"LINEAR", "STEPPED", "SMOOTHSTEP", "SMOOTHERSTEP"}),
        enum_param("data_type", {"FLOAT", "FLOAT_VECTOR"}), bool_param("clamp", true)},
       {}});
  // The node's number is its output socket's default; as a parameter it is `value`.
  kinds.push_back({"ShaderNodeValue",
                   NodeRole::kValue,
                   lower_value,
                   {},
                   {float_output("Value")},
                   {float_param("value", 0.0)},
                   {}});
  return kinds;
}

}  // namespace vernier
