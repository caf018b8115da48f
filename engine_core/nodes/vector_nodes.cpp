// Nodes on vectors: table and lowering.
#include "math/transform.h"
#include "nodes/node_tables.h"
#include "nodes/point_ops.h"
#include "nodes/vector_ops.h"

namespace vernier {
namespace {

constexpr SocketType kFloat = SocketType::kFloat;
constexpr SocketType kVector = SocketType::kVector;

// A mapping whose sockets are constant is a matrix, or nothing; but for normals, which become unit.
void lower_mapping(NodeLowering& node) {
  const auto kind = node.param_enum<MappingKind>("vector_type");
  const Value vector = node.input("Vector"), location = node.input("Location"),
              rotation = node.input("Rotation"), scale = node.input("Scale");
  ProgramBuilder& builder = node.builder();
  if (kind == MappingKind::kNormal || !builder.is_constant(location) ||
      !builder.is_constant(rotation) || !builder.is_constant(scale)) {
    node.set("Vector", node.emit(Op::kMapping, kind, kVector, {vector, location, rotation, scale}));
    return;
  }
  const Vec3f turn = builder.constant_value(rotation).xyz();
  const Vec3f size = builder.constant_value(scale).xyz();
  const Vec3f columns[] = {
      map_vector(kind, {1, 0, 0}, {}, turn, size), map_vector(kind, {0, 1, 0}, {}, turn, size),
      map_vector(kind, {0, 0, 1}, {}, turn, size),
      map_vector(kind, {}, builder.constant_value(location).xyz(), turn, size)};
  std::array<float, 12> rows;
  for (size_t i = 0; i < rows.size(); ++i) {
    rows[i] = columns[i % 4][static_cast<int>(i / 4)];
  }
  if (rows == Transform{}.m) {
    node.set("Vector", vector);
    return;
  }
  node.set("Vector", node.emit(Op::kMatrix, 0, kVector, {vector}, builder.add_floats(rows)));
}

void lower_vector_rotate(NodeLowering& node) {
  const auto kind = node.param_enum<RotationKind>("rotation_type");
  const bool invert = node.param_bool("invert");
  ProgramBuilder& builder = node.builder();
  const bool euler = kind == RotationKind::kEuler;
  Value turn = euler ? builder.constant(1.0f) : node.input("Angle");
  if (invert) {
    turn = builder.multiply(turn, builder.constant(-1.0f));
  }
  node.set("Vector", node.emit(Op::kVectorRotate, kind, kVector,
                               {node.input("Vector"), node.input("Center"),
                                node.input(euler ? "Rotation" : "Axis"), turn}));
}

void lower_vector_transform(NodeLowering& node) {
  const auto kind = static_cast<unsigned>(node.param_enum<TransformKind>("vector_type"));
  const auto from = static_cast<unsigned>(node.param_enum<VectorSpace>("convert_from"));
  const auto to = static_cast<unsigned>(node.param_enum<VectorSpace>("convert_to"));
  node.set("Vector", node.emit(Op::kVectorTransform, kind | from << 2 | to << 4, kVector,
                               {node.input("Vector")}));
}

void lower_combine(NodeLowering& node) {
  node.set("Vector", node.emit(Op::kCombine, 0, kVector,
                               {node.input("X"), node.input("Y"), node.input("Z")}));
}

void lower_separate(NodeLowering& node) {
  const Value v = node.input("Vector");
  node.set("X", node.emit(Op::kExtract, 0, kFloat, {v}));
  node.set("Y", node.emit(Op::kExtract, 1, kFloat, {v}));
  node.set("Z", node.emit(Op::kExtract, 2, kFloat, {v}));
}

void lower_normal(NodeLowering& node) {
  const std::vector<float> d = node.param_floats("direction");
  const Vec3f direction = d.size() == 3 ? normalize({d[0], d[1], d[2]}) : Vec3f{0, 0, 1};
  const Value constant = node.builder().constant(to_register(direction), kVector);
  node.set("Normal", constant);
  node.set("Dot", node.emit(Op::kNormalDot, 0, kFloat, {constant, node.input("Normal")}));
}

}  // namespace

// Normal has its output socket's value as the parameter `direction`.
std::vector<NodeKind> vector_node_kinds() {
  std::vector<NodeKind> kinds;
  kinds.push_back({"ShaderNodeMapping",
                   NodeRole::kValue,
                   lower_mapping,
                   {vector_input("Vector"), vector_input("Location"), vector_input("Rotation"),
                    vector_input("Scale", 1, 1, 1)},
                   {vector_output("Vector")},
                   {enum_param("vector_type", {"POINT", "TEXTURE", "VECTOR", "NORMAL"})},
                   {}});
  kinds.push_back(
      {"ShaderNodeVectorRotate",
       NodeRole::kValue,
       lower_vector_rotate,
       {vector_input("Vector"), vector_input("Center"), vector_input("Axis", 0, 0, 1),
        float_input("Angle", 0.0f), vector_input("Rotation")},
       {vector_output("Vector")},
       {enum_param("rotation_type", {"AXIS_ANGLE", "X_AXIS", "Y_AXIS", "Z_AXIS", "EULER_XYZ"}),
        bool_param("invert", false)},
       {}});
  kinds.push_back({"ShaderNodeVectorTransform",
                   NodeRole::kValue,
                   lower_vector_transform,
                   {vector_input("Vector", 0.5f, 0.5f, 0.5f)},
                   {vector_output("Vector")},
                   {enum_param("vector_type", {"VECTOR", "POINT", "NORMAL"}),
                    enum_param("convert_from", {"WORLD", "OBJECT", "CAMERA"}),
                    enum_param("convert_to", {"WORLD", "OBJECT", "CAMERA"})},
                   {}});
  kinds.push_back({"ShaderNodeCombineXYZ",
                   NodeRole::kValue,
                   lower_combine,
                   {float_input("X", 0.0f), float_input("Y", 0.0f), float_input("Z", 0.0f)},
                   {vector_output("Vector")},
                   {},
                   {}});
  kinds.push_back({"ShaderNodeSeparateXYZ",
                   NodeRole::kValue,
                   lower_separate,
                   {vector_input("Vector")},
                   {float_output("X"), float_output("Y"), float_output("Z")},
                   {},
                   {}});
  kinds.push_back({"ShaderNodeNormal",
                   NodeRole::kValue,
                   lower_normal,
                   {vector_input("Normal", 0, 0, 1)},
                   {vector_output("Normal"), float_output("Dot")},
                   {floats_param("direction")},
                   {}});
  return kinds;
}

}  // namespace vernier
