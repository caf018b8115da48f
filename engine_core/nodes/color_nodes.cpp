// Colour nodes: table and lowering.
#include "nodes/color_ops.h"
#include "nodes/color_ramp.h"
#include "nodes/node_tables.h"
#include "nodes/texture_ops.h"

namespace vernier {
namespace {

constexpr SocketType kFloat = SocketType::kFloat;
constexpr SocketType kVector = SocketType::kVector;
constexpr SocketType kColor = SocketType::kColor;

std::vector<std::string_view> blend_items() {
  return {"MIX",    "DARKEN",  "MULTIPLY",   "BURN",         "LIGHTEN",    "SCREEN",    "DODGE",
          "ADD",    "OVERLAY", "SOFT_LIGHT", "LINEAR_LIGHT", "DIFFERENCE", "EXCLUSION", "SUBTRACT",
          "DIVIDE", "HUE",     "SATURATION", "COLOR",        "VALUE"};
}

void lower_mix(NodeLowering& node) {
  enum class DataType { kNumbers, kVectors, kColors, kRotations };
  const auto type = node.param_enum<DataType>("data_type");
  const bool clamps = node.param_bool("clamp_factor");
  const auto clamped = [&](Value factor, SocketType t) {
    return clamps ? node.emit(Op::kSaturate, 0, t, {factor}) : factor;
  };
  for (const std::string_view output :
       {"Result_Float", "Result_Vector", "Result_Color", "Result_Rotation"}) {
    node.set(output, node.builder().constant(0.0f));
  }
  if (type == DataType::kRotations) {
    node.warn("rotations are not supported; the result is zero");
  } else if (type == DataType::kNumbers) {
    node.set("Result_Float", node.emit(Op::kMixFloat, 0, kFloat,
                                       {clamped(node.input("Factor_Float"), kFloat),
                                        node.input("A_Float"), node.input("B_Float")}));
  } else if (type == DataType::kVectors) {
    enum class FactorMode { kUniform, kNonUniform };
    const bool uniform = node.param_enum<FactorMode>("factor_mode") == FactorMode::kUniform;
    const Value factor = uniform ? clamped(node.input("Factor_Float"), kFloat)
                                 : clamped(node.input("Factor_Vector"), kVector);
    node.set("Result_Vector", node.emit(Op::kMixVector, 0, kVector,
                                        {node.builder().convert(factor, kVector),
                                         node.input("A_Vector"), node.input("B_Vector")}));
  } else {
    Value color = node.emit(Op::kBlend, node.param_enum<BlendMode>("blend_type"), kColor,
                            {clamped(node.input("Factor_Float"), kFloat), node.input("A_Color"),
                             node.input("B_Color")});
    if (node.param_bool("clamp_result")) {
      color = node.emit(Op::kSaturate, 0, kColor, {color});
    }
    node.set("Result_Color", color);
  }
}

void lower_mix_rgb(NodeLowering& node) {
  const Value factor = node.emit(Op::kSaturate, 0, kFloat, {node.input("Fac")});
  Value color = node.emit(Op::kBlend, node.param_enum<BlendMode>("blend_type"), kColor,
                          {factor, node.input("Color1"), node.input("Color2")});
  if (node.param_bool("use_clamp")) {
    color = node.emit(Op::kSaturate, 0, kColor, {color});
  }
  node.set("Color", color);
}

// Data of a table: see TableHeader.
uint32_t add_table(NodeLowering& node, std::span<const float> rows, float min, float max,
                   bool extrapolate) {
  std::vector<float> table{static_cast<float>(rows.size() / 4), min, max,
                           extrapolate ? 1.0f : 0.0f};
  table.insert(table.end(), rows.begin(), rows.end());
  return node.builder().add_floats(table);
}

void lower_ramp(NodeLowering& node) {
  std::vector<float> stops = node.param_floats("ramp");
  if (stops.size() < 5 || stops.size() % 5 != 0) {
    node.warn("the ramp has no rows of five numbers; it goes from black to white");
    stops = {0, 0, 0, 0, 1, 1, 1, 1, 1, 1};
  }
  RampStyle style;
  style.interpolation = node.param_enum<RampInterpolation>("interpolation");
  style.mode = node.param_enum<RampMode>("color_mode");
  style.hue = node.param_enum<HueInterpolation>("hue_interpolation");
  const uint32_t table = add_table(node, sample_ramp(stops, style), 0.0f, 1.0f, false);
  const bool interpolates = style.interpolation != RampInterpolation::kConstant;
  const Value color =
      node.emit(Op::kRamp, interpolates ? 1 : 0, kColor, {node.input("Fac")}, table);
  node.set("Color", color);
  if (node.wants("Alpha")) {
    node.set("Alpha", node.emit(Op::kExtract, 3, kFloat, {color}));
  }
}

// A curve node of `channels` channels between a factor and a value.
void lower_curves(NodeLowering& node, size_t channels, std::string_view factor,
                  std::string_view socket, SocketType type) {
  const std::vector<float> table = node.param_floats("curves");
  const float min = node.param_float("min_x"), max = node.param_float("max_x");
  if (table.size() < 2 * channels || table.size() % channels != 0 || !(min < max)) {
    node.warn("it has no table of curves; values pass unchanged");
    node.set(socket, node.input(socket));
    return;
  }
  std::vector<float> rows;
  for (size_t i = 0; i < table.size(); i += channels) {
    for (size_t c = 0; c < 4; ++c) {
      rows.push_back(table[i + std::min(c, channels - 1)]);
    }
  }
  const uint32_t data = add_table(node, rows, min, max, node.param_bool("extrapolate"));
  node.set(socket, node.emit(Op::kCurves, 0, type, {node.input(factor), node.input(socket)}, data));
}
void lower_rgb_curve(NodeLowering& node) { lower_curves(node, 3, "Fac", "Color", kColor); }
void lower_vector_curve(NodeLowering& node) { lower_curves(node, 3, "Fac", "Vector", kVector); }
void lower_float_curve(NodeLowering& node) { lower_curves(node, 1, "Factor", "Value", kFloat); }

void lower_gamma(NodeLowering& node) {
  node.set("Color", node.emit(Op::kGamma, 0, kColor, {node.input("Color"), node.input("Gamma")}));
}
void lower_hue_saturation(NodeLowering& node) {
  node.set("Color", node.emit(Op::kHueSaturation, 0, kColor,
                              {node.input("Color"), node.input("Hue"), node.input("Saturation"),
                               node.input("Value"), node.input("Fac")}));
}
void lower_bright_contrast(NodeLowering& node) {
  node.set("Color", node.emit(Op::kBrightContrast, 0, kColor,
                              {node.input("Color"), node.input("Bright"), node.input("Contrast")}));
}
void lower_invert(NodeLowering& node) {
  node.set("Color", node.emit(Op::kInvert, 0, kColor, {node.input("Fac"), node.input("Color")}));
}
void lower_rgb_to_bw(NodeLowering& node) {
  node.set("Val", node.emit(Op::kLuminance, 0, kFloat, {node.input("Color")}));
}
void lower_blackbody(NodeLowering& node) {
  node.set("Color", node.emit(Op::kBlackbody, 0, kColor, {node.input("Temperature")}));
}

void combine(NodeLowering& node, ColorModel model, std::string_view a, std::string_view b,
             std::string_view c, std::string_view output) {
  node.set(output, node.emit(Op::kCombineColor, model, kColor,
                             {node.input(a), node.input(b), node.input(c)}));
}
void separate(NodeLowering& node, ColorModel model, std::string_view input, std::string_view a,
              std::string_view b, std::string_view c) {
  const Value parts = node.emit(Op::kSeparateColor, model, kVector, {node.input(input)});
  node.set(a, node.emit(Op::kExtract, 0, kFloat, {parts}));
  node.set(b, node.emit(Op::kExtract, 1, kFloat, {parts}));
  node.set(c, node.emit(Op::kExtract, 2, kFloat, {parts}));
}
void lower_combine_color(NodeLowering& node) {
  combine(node, node.param_enum<ColorModel>("mode"), "Red", "Green", "Blue", "Color");
}
void lower_separate_color(NodeLowering& node) {
  separate(node, node.param_enum<ColorModel>("mode"), "Color", "Red", "Green", "Blue");
}
void lower_combine_rgb(NodeLowering& node) {
  combine(node, ColorModel::kRgb, "R", "G", "B", "Image");
}
void lower_separate_rgb(NodeLowering& node) {
  separate(node, ColorModel::kRgb, "Image", "R", "G", "B");
}
void lower_combine_hsv(NodeLowering& node) {
  combine(node, ColorModel::kHsv, "H", "S", "V", "Color");
}
void lower_separate_hsv(NodeLowering& node) {
  separate(node, ColorModel::kHsv, "Color", "H", "S", "V");
}

void lower_rgb(NodeLowering& node) {
  const std::vector<float> c = node.param_floats("color");
  const bool given = c.size() >= 3;
  if (!given) {
    node.warn("it has no colour; 0.5 grey is used");
  }
  node.set("Color", node.builder().constant(
                        given ? Vec4f{c[0], c[1], c[2], 1.0f} : to_register(0.5f), kColor));
}

NodeKind color_kind(std::string_view name, void (*lower)(NodeLowering&),
                    std::vector<InputKind> inputs, std::vector<OutputKind> outputs,
                    std::vector<ParamKind> params = {}) {
  return {name, NodeRole::kValue, lower, std::move(inputs), std::move(outputs), std::move(params),
          {}};
}

std::vector<ParamKind> curve_params() {
  return {floats_param("curves"), float_param("min_x", 0.0), float_param("max_x", 1.0),
          bool_param("extrapolate", false)};
}

}  // namespace

// Forms of what are no plain properties: RGB has its socket's value as `color`; the ramp's rows are
// (position, r, g, b, a); `curves` are tables of rows (r, g, b), (x, y, z) or (value) at equal
// steps from min_x to max_x, the combined curve applied.
std::vector<NodeKind> color_node_kinds() {
  return {
      color_kind(
          "ShaderNodeMix", lower_mix,
          {float_input("Factor_Float", 0.5f), vector_input("Factor_Vector", 0.5f, 0.5f, 0.5f),
           float_input("A_Float", 0.0f), float_input("B_Float", 0.0f), vector_input("A_Vector"),
           vector_input("B_Vector"), color_input("A_Color", 0.5f), color_input("B_Color", 0.5f),
           vector_input("A_Rotation"), vector_input("B_Rotation")},
          {float_output("Result_Float"), vector_output("Result_Vector"),
           color_output("Result_Color"), vector_output("Result_Rotation")},
          {enum_param("data_type", {"FLOAT", "VECTOR", "RGBA", "ROTATION"}),
           enum_param("factor_mode", {"UNIFORM", "NON_UNIFORM"}),
           enum_param("blend_type", blend_items()), bool_param("clamp_factor", true),
           bool_param("clamp_result", false)}),
      color_kind(
          "ShaderNodeMixRGB", lower_mix_rgb,
          {float_input("Fac", 0.5f), color_input("Color1", 0.5f), color_input("Color2", 0.5f)},
          {color_output("Color")},
          {enum_param("blend_type", blend_items()), bool_param("use_alpha", false),
           bool_param("use_clamp", false)}),
      color_kind(
          "ShaderNodeValToRGB", lower_ramp, {float_input("Fac", 0.5f)},
          {color_output("Color"), float_output("Alpha")},
          {floats_param("ramp"),
           enum_param("interpolation", {"LINEAR", "EASE", "B_SPLINE", "CARDINAL", "CONSTANT"}),
           enum_param("color_mode", {"RGB", "HSV", "HSL"}),
           enum_param("hue_interpolation", {"NEAR", "FAR", "CW", "CCW"})}),
      color_kind("ShaderNodeRGBCurve", lower_rgb_curve,
                 {float_input("Fac", 1.0f), color_input("Color", 1.0f)}, {color_output("Color")},
                 curve_params()),
      color_kind("ShaderNodeVectorCurve", lower_vector_curve,
                 {float_input("Fac", 1.0f), vector_input("Vector")}, {vector_output("Vector")},
                 curve_params()),
      color_kind("ShaderNodeFloatCurve", lower_float_curve,
                 {float_input("Factor", 1.0f), float_input("Value", 1.0f)}, {float_output("Value")},
                 curve_params()),
      color_kind("ShaderNodeGamma", lower_gamma,
                 {color_input("Color", 1.0f), float_input("Gamma", 1.0f)}, {color_output("Color")}),
      color_kind("ShaderNodeHueSaturation", lower_hue_saturation,
                 {float_input("Hue", 0.5f), float_input("Saturation", 1.0f),
                  float_input("Value", 1.0f), float_input("Fac", 1.0f), color_input("Color", 0.8f)},
                 {color_output("Color")}),
      color_kind(
          "ShaderNodeBrightContrast", lower_bright_contrast,
          {color_input("Color", 1.0f), float_input("Bright", 0.0f), float_input("Contrast", 0.0f)},
          {color_output("Color")}),
      color_kind("ShaderNodeInvert", lower_invert,
                 {float_input("Fac", 1.0f), color_input("Color", 0.0f)}, {color_output("Color")}),
      color_kind("ShaderNodeRGBToBW", lower_rgb_to_bw, {color_input("Color", 0.5f)},
                 {float_output("Val")}),
      color_kind("ShaderNodeBlackbody", lower_blackbody, {float_input("Temperature", 1500.0f)},
                 {color_output("Color")}),
      color_kind("ShaderNodeCombineColor", lower_combine_color,
                 {float_input("Red", 0.0f), float_input("Green", 0.0f), float_input("Blue", 0.0f)},
                 {color_output("Color")}, {enum_param("mode", {"RGB", "HSV", "HSL"})}),
      color_kind("ShaderNodeSeparateColor", lower_separate_color, {color_input("Color", 0.8f)},
                 {float_output("Red"), float_output("Green"), float_output("Blue")},
                 {enum_param("mode", {"RGB", "HSV", "HSL"})}),
      color_kind("ShaderNodeCombineRGB", lower_combine_rgb,
                 {float_input("R", 0.0f), float_input("G", 0.0f), float_input("B", 0.0f)},
                 {color_output("Image")}),
      color_kind("ShaderNodeSeparateRGB", lower_separate_rgb, {color_input("Image", 0.8f)},
                 {float_output("R"), float_output("G"), float_output("B")}),
      color_kind("ShaderNodeCombineHSV", lower_combine_hsv,
                 {float_input("H", 0.0f), float_input("S", 0.0f), float_input("V", 0.0f)},
                 {color_output("Color")}),
      color_kind("ShaderNodeSeparateHSV", lower_separate_hsv, {color_input("Color", 0.8f)},
                 {float_output("H"), float_output("S"), float_output("V")}),
      color_kind("ShaderNodeRGB", lower_rgb, {}, {color_output("Color")}, {floats_param("color")}),
  };
}

}  // namespace vernier
