// Nodes that read the surface point: table and lowering.
#include "math/transform.h"
#include "nodes/node_tables.h"
#include "nodes/point_ops.h"

namespace vernier {
namespace {

constexpr SocketType kFloat = SocketType::kFloat;
constexpr SocketType kVector = SocketType::kVector;
constexpr SocketType kColor = SocketType::kColor;

// Sets `output` to what an operation without operands gives, where anything reads it.
template <typename Variant>
void set_read(NodeLowering& node, std::string_view output, Op op, Variant variant, SocketType type,
              uint32_t data = 0) {
  if (node.wants(output)) {
    node.set(output, node.emit(op, variant, type, {}, data));
  }
}

void set_unsupported(NodeLowering& node, std::string_view output, float value) {
  if (node.wants(output)) {
    node.warn("output '" + std::string(output) + "' is not supported; it is " +
              (value == 0.0f ? "0" : "0.5"));
    node.set(output, node.builder().constant(value));
  }
}

void lower_tex_coord(NodeLowering& node) {
  set_read(node, "Generated", Op::kGeometry, GeometryValue::kGenerated, kVector);
  set_read(node, "Normal", Op::kGeometry, GeometryValue::kObjectNormal, kVector);
  set_read(node, "Reflection", Op::kGeometry, GeometryValue::kReflection, kVector);
  set_read(node, "Camera", Op::kCamera, CameraValue::kPosition, kVector);
  set_read(node, "Window", Op::kCamera, CameraValue::kWindow, kVector);
  if (node.wants("UV")) {
    set_read(node, "UV", Op::kAttribute, AttributeUse::kVector, kVector,
             node.context().attribute_id(kActiveUvAttribute));
  }
  if (node.wants("Object")) {
    const std::vector<float> rows = node.param_floats("object_to_world");
    Transform to_world;
    if (rows.size() != to_world.m.size()) {
      set_read(node, "Object", Op::kGeometry, GeometryValue::kObject, kVector);
      return;
    }
    std::copy(rows.begin(), rows.end(), to_world.m.begin());
    const uint32_t data = node.builder().add_floats(inverse(to_world).m);
    const Value p = node.emit(Op::kGeometry, GeometryValue::kPosition, kVector, {});
    node.set("Object", node.emit(Op::kMatrix, 0, kVector, {p}, data));
  }
}

void lower_uv_map(NodeLowering& node) {
  set_read(node, "UV", Op::kAttribute, AttributeUse::kVector, kVector,
           node.context().attribute_id(node.param_string("uv_map")));
}

void lower_attribute(NodeLowering& node) {
  enum class Kind { kGeometry, kObject, kInstancer, kViewLayer };
  if (node.param_enum<Kind>("attribute_type") != Kind::kGeometry) {
    node.warn("only attributes of the geometry are supported; this one is 0");
    for (const std::string_view output : {"Color", "Vector", "Fac", "Alpha"}) {
      node.set(output, node.builder().constant(0.0f));
    }
    return;
  }
  const uint32_t id = node.context().attribute_id(node.param_string("attribute_name"));
  set_read(node, "Color", Op::kAttribute, AttributeUse::kVector, kColor, id);
  set_read(node, "Vector", Op::kAttribute, AttributeUse::kVector, kVector, id);
  set_read(node, "Fac", Op::kAttribute, AttributeUse::kFactor, kFloat, id);
  set_read(node, "Alpha", Op::kAttribute, AttributeUse::kAlpha, kFloat, id);
}

void lower_color_attribute(NodeLowering& node) {
  const std::string name = node.param_string("layer_name");
  const uint32_t id =
      node.context().attribute_id(name.empty() ? std::string(kActiveColorAttribute) : name);
  set_read(node, "Color", Op::kAttribute, AttributeUse::kVector, kColor, id);
  set_read(node, "Alpha", Op::kAttribute, AttributeUse::kColorAlpha, kFloat, id);
}

void lower_geometry(NodeLowering& node) {
  set_read(node, "Position", Op::kGeometry, GeometryValue::kPosition, kVector);
  set_read(node, "Normal", Op::kGeometry, GeometryValue::kNormal, kVector);
  set_read(node, "Tangent", Op::kGeometry, GeometryValue::kTangent, kVector);
  set_read(node, "True Normal", Op::kGeometry, GeometryValue::kTrueNormal, kVector);
  set_read(node, "Incoming", Op::kGeometry, GeometryValue::kIncoming, kVector);
  set_read(node, "Parametric", Op::kGeometry, GeometryValue::kParametric, kVector);
  set_read(node, "Backfacing", Op::kGeometry, GeometryValue::kBackfacing, kFloat);
  set_unsupported(node, "Pointiness", 0.5f);
  set_unsupported(node, "Random Per Island", 0.0f);
}

constexpr std::string_view kLightPathOutputs[] = {
    "Is Camera Ray",     "Is Shadow Ray",      "Is Diffuse Ray",      "Is Glossy Ray",
    "Is Singular Ray",   "Is Reflection Ray",  "Is Transmission Ray", "Is Volume Scatter Ray",
    "Ray Length",        "Ray Depth",          "Diffuse Depth",       "Glossy Depth",
    "Transparent Depth", "Transmission Depth", "Portal Depth"};

void lower_light_path(NodeLowering& node) {
  uint8_t value = 0;
  for (const std::string_view output : kLightPathOutputs) {
    set_read(node, output, Op::kLightPath, value++, kFloat);
  }
}

void lower_object_info(NodeLowering& node) {
  set_read(node, "Location", Op::kObjectInfo, ObjectValue::kLocation, kVector);
  set_read(node, "Color", Op::kObjectInfo, ObjectValue::kColor, kColor);
  set_read(node, "Alpha", Op::kObjectInfo, ObjectValue::kAlpha, kFloat);
  set_read(node, "Object Index", Op::kObjectInfo, ObjectValue::kObjectIndex, kFloat);
  set_read(node, "Random", Op::kObjectInfo, ObjectValue::kRandom, kFloat);
  set_read(node, "Material Index", Op::kObjectInfo, ObjectValue::kMaterialIndex, kFloat);
}

void lower_camera_data(NodeLowering& node) {
  set_read(node, "View Vector", Op::kCamera, CameraValue::kVector, kVector);
  set_read(node, "View Z Depth", Op::kCamera, CameraValue::kDepth, kFloat);
  set_read(node, "View Distance", Op::kCamera, CameraValue::kDistance, kFloat);
}

void lower_fresnel(NodeLowering& node) {
  node.set("Fac", node.emit(Op::kFresnel, 0, kFloat, {node.input("IOR"), node.input("Normal")}));
}

void lower_layer_weight(NodeLowering& node) {
  const Value blend = node.input("Blend"), normal = node.input("Normal");
  if (node.wants("Fresnel")) {
    node.set("Fresnel",
             node.emit(Op::kLayerWeight, LayerWeightKind::kFresnel, kFloat, {blend, normal}));
  }
  if (node.wants("Facing")) {
    node.set("Facing",
             node.emit(Op::kLayerWeight, LayerWeightKind::kFacing, kFloat, {blend, normal}));
  }
}

void lower_light_falloff(NodeLowering& node) {
  const Value strength = node.input("Strength"), smooth = node.input("Smooth");
  uint8_t power = 0;  // of the distance, against the inverse square law
  for (const std::string_view output : {"Quadratic", "Linear", "Constant"}) {
    if (node.wants(output)) {
      node.set(output, node.emit(Op::kLightFalloff, power, kFloat, {strength, smooth}));
    }
    ++power;
  }
}

NodeKind input_kind(std::string_view name, void (*lower)(NodeLowering&),
                    std::vector<OutputKind> outputs, std::vector<ParamKind> params = {},
                    std::vector<InputKind> inputs = {}) {
  return {name, NodeRole::kValue, lower, std::move(inputs), std::move(outputs), std::move(params),
          {}};
}

std::vector<OutputKind> light_path_outputs() {
  std::vector<OutputKind> outputs;
  for (const std::string_view name : kLightPathOutputs) {
    outputs.push_back(float_output(name));
  }
  return outputs;
}

}  // namespace

// Texture Coordinate's object is `object_to_world`: the rows of its matrix; absent for the object
// that is shaded.
std::vector<NodeKind> input_node_kinds() {
  return {
      input_kind("ShaderNodeTexCoord", lower_tex_coord,
                 {vector_output("Generated"), vector_output("Normal"), vector_output("UV"),
                  vector_output("Object"), vector_output("Camera"), vector_output("Window"),
                  vector_output("Reflection")},
                 {floats_param("object_to_world"), bool_param("from_instancer", false)}),
      input_kind("ShaderNodeUVMap", lower_uv_map, {vector_output("UV")},
                 {string_param("uv_map"), bool_param("from_instancer", false)}),
      input_kind("ShaderNodeAttribute", lower_attribute,
                 {color_output("Color"), vector_output("Vector"), float_output("Fac"),
                  float_output("Alpha")},
                 {string_param("attribute_name"),
                  enum_param("attribute_type", {"GEOMETRY", "OBJECT", "INSTANCER", "VIEW_LAYER"})}),
      input_kind("ShaderNodeVertexColor", lower_color_attribute,
                 {color_output("Color"), float_output("Alpha")}, {string_param("layer_name")}),
      input_kind("ShaderNodeNewGeometry", lower_geometry,
                 {vector_output("Position"), vector_output("Normal"), vector_output("Tangent"),
                  vector_output("True Normal"), vector_output("Incoming"),
                  vector_output("Parametric"), float_output("Backfacing"),
                  float_output("Pointiness"), float_output("Random Per Island")}),
      input_kind("ShaderNodeLightPath", lower_light_path, light_path_outputs()),
      input_kind(
          "ShaderNodeObjectInfo", lower_object_info,
          {vector_output("Location"), color_output("Color"), float_output("Alpha"),
           float_output("Object Index"), float_output("Material Index"), float_output("Random")}),
      input_kind("ShaderNodeCameraData", lower_camera_data,
                 {vector_output("View Vector"), float_output("View Z Depth"),
                  float_output("View Distance")}),
      input_kind("ShaderNodeFresnel", lower_fresnel, {float_output("Fac")}, {},
                 {float_input("IOR", 1.5f), vector_input("Normal", SocketSource::kNormal)}),
      input_kind("ShaderNodeLayerWeight", lower_layer_weight,
                 {float_output("Fresnel"), float_output("Facing")}, {},
                 {float_input("Blend", 0.5f), vector_input("Normal", SocketSource::kNormal)}),
      input_kind("ShaderNodeLightFalloff", lower_light_falloff,
                 {float_output("Quadratic"), float_output("Linear"), float_output("Constant")}, {},
                 {float_input("Strength", 100.0f), float_input("Smooth", 0.0f)}),
  };
}

}  // namespace vernier
