// Procedural textures: table and lowering.
#include "nodes/node_tables.h"
#include "nodes/texture_ops.h"
#include "textures/noise.h"
#include "textures/patterns.h"
#include "textures/voronoi.h"

namespace vernier {
namespace {

constexpr SocketType kFloat = SocketType::kFloat;
constexpr SocketType kColor = SocketType::kColor;

enum class Dimensions { k3D, k1D, k2D, k4D };

// Dimensions less one, as variants hold them.
unsigned dimension_bits(NodeLowering& node, std::string_view param) {
  switch (node.param_enum<Dimensions>(param)) {
    case Dimensions::k1D:
      return 0;
    case Dimensions::k2D:
      return 1;
    case Dimensions::k3D:
      return 2;
    case Dimensions::k4D:
      return 3;
  }
  return 2;
}

std::vector<std::string_view> dimension_items() { return {"3D", "1D", "2D", "4D"}; }

void lower_noise(NodeLowering& node) {
  const auto kind = static_cast<unsigned>(node.param_enum<NoiseKind>("noise_type"));
  const unsigned bits = dimension_bits(node, "noise_dimensions") | kind << 2 |
                        (node.param_bool("normalize") ? 32u : 0u);
  const auto emit = [&](unsigned variant, SocketType type) {
    return node.emit(Op::kNoise, variant, type,
                     {node.input("Vector"), node.input("W"), node.input("Scale"),
                      node.input("Detail"), node.input("Roughness"), node.input("Lacunarity"),
                      node.input("Offset"), node.input("Gain"), node.input("Distortion")});
  };
  if (node.wants("Color")) {
    const Value color = emit(bits | 64u, kColor);
    node.set("Color", color);
    node.set("Fac", node.emit(Op::kExtract, 0, kFloat, {color}));
  } else {
    node.set("Fac", emit(bits, kFloat));
  }
}

// Colour in xyz and Fac in w of one instruction.
void set_color_and_factor(NodeLowering& node, Value value) {
  node.set("Color", value);
  if (node.wants("Fac")) {
    node.set("Fac", node.emit(Op::kExtract, 3, kFloat, {value}));
  }
}

void lower_checker(NodeLowering& node) {
  set_color_and_factor(node, node.emit(Op::kChecker, 0, kColor,
                                       {node.input("Vector"), node.input("Color1"),
                                        node.input("Color2"), node.input("Scale")}));
}

void lower_brick(NodeLowering& node) {
  const float data[] = {node.param_float("offset"), node.param_float("squash"),
                        static_cast<float>(node.param_int("offset_frequency")),
                        static_cast<float>(node.param_int("squash_frequency"))};
  const uint32_t first = node.builder().add_floats(data);
  set_color_and_factor(
      node, node.emit(Op::kBrick, 0, kColor,
                      {node.input("Vector"), node.input("Color1"), node.input("Color2"),
                       node.input("Mortar"), node.input("Scale"), node.input("Mortar Size"),
                       node.input("Mortar Smooth"), node.input("Bias"), node.input("Brick Width"),
                       node.input("Row Height")},
                      first));
}

// Textures whose colour is grey: one scalar for both outputs.
void set_grey(NodeLowering& node, Value value) {
  node.set("Color", node.builder().convert(value, kColor));
  node.set("Fac", value);
}

void lower_gradient(NodeLowering& node) {
  set_grey(node, node.emit(Op::kGradient, node.param_enum<GradientKind>("gradient_type"), kFloat,
                           {node.input("Vector")}));
}

void lower_wave(NodeLowering& node) {
  const auto kind = node.param_enum<WaveKind>("wave_type");
  const auto direction = node.param_enum<WaveDirection>(
      kind == WaveKind::kBands ? "bands_direction" : "rings_direction");
  const auto profile = node.param_enum<WaveProfile>("wave_profile");
  const unsigned variant = static_cast<unsigned>(kind) | static_cast<unsigned>(direction) << 1 |
                           static_cast<unsigned>(profile) << 3;
  set_grey(node, node.emit(Op::kWave, variant, kFloat,
                           {node.input("Vector"), node.input("Scale"), node.input("Distortion"),
                            node.input("Detail"), node.input("Detail Scale"),
                            node.input("Detail Roughness"), node.input("Phase Offset")}));
}

void lower_magic(NodeLowering& node) {
  const int depth = std::min(std::max(node.param_int("turbulence_depth"), 0), 10);
  const Value color =
      node.emit(Op::kMagic, depth, kColor,
                {node.input("Vector"), node.input("Scale"), node.input("Distortion")});
  node.set("Color", color);
  node.set("Fac", node.emit(Op::kAverage, 0, kFloat, {color}));
}

void lower_white_noise(NodeLowering& node) {
  const unsigned bits = dimension_bits(node, "noise_dimensions");
  const Value p = node.input("Vector"), w = node.input("W");
  if (node.wants("Color")) {
    node.set("Color", node.emit(Op::kWhiteNoise, bits | 4u, kColor, {p, w}));
  }
  if (node.wants("Value")) {
    node.set("Value", node.emit(Op::kWhiteNoise, bits, kFloat, {p, w}));
  }
}

void lower_voronoi(NodeLowering& node) {
  const auto feature = node.param_enum<VoronoiFeature>("feature");
  const float data[] = {static_cast<float>(dimension_bits(node, "voronoi_dimensions") + 1),
                        static_cast<float>(feature),
                        static_cast<float>(node.param_enum<VoronoiMetric>("distance")),
                        node.param_bool("normalize") ? 1.0f : 0.0f};
  const uint32_t first = node.builder().add_floats(data);
  const auto emit = [&](VoronoiOutput output) {
    return node.emit(Op::kVoronoi, output, kColor,
                     {node.input("Vector"), node.input("W"), node.input("Scale"),
                      node.input("Detail"), node.input("Roughness"), node.input("Lacunarity"),
                      node.input("Smoothness"), node.input("Exponent"), node.input("Randomness")},
                     first);
  };
  const Value cell = emit(VoronoiOutput::kColorAndDistance);
  const Value scalar = node.emit(Op::kExtract, 3, kFloat, {cell});
  const Value zero = node.builder().constant(0.0f);
  const bool is_radius = feature == VoronoiFeature::kNSphereRadius;
  node.set("Color", cell);
  node.set("Distance", is_radius ? zero : scalar);
  node.set("Radius", is_radius ? scalar : zero);
  if (node.wants("Position") || node.wants("W")) {
    const Value position = emit(VoronoiOutput::kPosition);
    node.set("Position", position);
    node.set("W", node.emit(Op::kExtract, 3, kFloat, {position}));
  }
}

// Preetham's sky is exact; the others are replaced by it, which is told.
void lower_sky(NodeLowering& node) {
  enum class Sky { kMultipleScattering, kSingleScattering, kPreetham, kHosekWilkie, kNishita };
  const auto sky = node.param_enum<Sky>("sky_type");
  const std::vector<float> given = node.param_floats("sun_direction");
  Vec3f sun = given.size() == 3 ? normalize({given[0], given[1], given[2]}) : Vec3f{0, 0, 1};
  if (sky != Sky::kPreetham) {
    node.warn(
        "this kind of sky is not supported; it is replaced by Preetham's, without the disc "
        "of the sun and of another brightness");
  }
  if (sky != Sky::kPreetham && sky != Sky::kHosekWilkie) {
    // Their rotation turns from +y toward +x.
    const float elevation = node.param_float("sun_elevation");
    const float rotation = node.param_float("sun_rotation");
    sun = {std::cos(elevation) * std::sin(rotation), std::cos(elevation) * std::cos(rotation),
           std::max(std::sin(elevation), 0.0f)};
  }
  const uint32_t data = node.builder().add_sky(PreethamSky(sun, node.param_float("turbidity")));
  node.set("Color", node.emit(Op::kSky, 0, kColor, {node.input("Vector")}, data));
}

NodeKind texture_kind(std::string_view name, void (*lower)(NodeLowering&),
                      std::vector<InputKind> inputs, std::vector<OutputKind> outputs,
                      std::vector<ParamKind> params = {}) {
  inputs.insert(inputs.begin(), vector_input("Vector", SocketSource::kGenerated));
  return {name, NodeRole::kValue, lower, std::move(inputs), std::move(outputs), std::move(params),
          {}};
}

}  // namespace

std::vector<NodeKind> texture_node_kinds() {
  std::vector<NodeKind> kinds{
      texture_kind(
          "ShaderNodeTexNoise", lower_noise,
          {float_input("W", 0.0f), float_input("Scale", 5.0f), float_input("Detail", 2.0f),
           float_input("Roughness", 0.5f), float_input("Lacunarity", 2.0f),
           float_input("Offset", 0.0f), float_input("Gain", 1.0f), float_input("Distortion", 0.0f)},
          {float_output("Fac"), color_output("Color")},
          {enum_param("noise_dimensions", dimension_items()),
           enum_param("noise_type", {"FBM", "MULTIFRACTAL", "RIDGED_MULTIFRACTAL",
                                     "HYBRID_MULTIFRACTAL", "HETERO_TERRAIN"}),
           bool_param("normalize", true)}),
      texture_kind(
          "ShaderNodeTexChecker", lower_checker,
          {color_input("Color1", 0.8f), color_input("Color2", 0.2f), float_input("Scale", 5.0f)},
          {color_output("Color"), float_output("Fac")}),
      texture_kind(
          "ShaderNodeTexBrick", lower_brick,
          {color_input("Color1", 0.8f), color_input("Color2", 0.2f), color_input("Mortar", 0.0f),
           float_input("Scale", 5.0f), float_input("Mortar Size", 0.02f),
           float_input("Mortar Smooth", 0.1f), float_input("Bias", 0.0f),
           float_input("Brick Width", 0.5f), float_input("Row Height", 0.25f)},
          {color_output("Color"), float_output("Fac")},
          {float_param("offset", 0.5), int_param("offset_frequency", 2), float_param("squash", 1.0),
           int_param("squash_frequency", 2)}),
      texture_kind("ShaderNodeTexGradient", lower_gradient, {},
                   {color_output("Color"), float_output("Fac")},
                   {enum_param("gradient_type", {"LINEAR", "QUADRATIC", "EASING", "DIAGONAL",
                                                 "SPHERICAL", "QUADRATIC_SPHERE", "RADIAL"})}),
      texture_kind("ShaderNodeTexWave", lower_wave,
                   {float_input("Scale", 5.0f), float_input("Distortion", 0.0f),
                    float_input("Detail", 2.0f), float_input("Detail Scale", 1.0f),
                    float_input("Detail Roughness", 0.5f), float_input("Phase Offset", 0.0f)},
                   {color_output("Color"), float_output("Fac")},
                   {enum_param("wave_type", {"BANDS", "RINGS"}),
                    enum_param("bands_direction", {"X", "Y", "Z", "DIAGONAL"}),
                    enum_param("rings_direction", {"X", "Y", "Z", "SPHERICAL"}),
                    enum_param("wave_profile", {"SIN", "SAW", "TRI"})}),
      texture_kind("ShaderNodeTexMagic", lower_magic,
                   {float_input("Scale", 5.0f), float_input("Distortion", 1.0f)},
                   {color_output("Color"), float_output("Fac")},
                   {int_param("turbulence_depth", 2)}),
      texture_kind(
          "ShaderNodeTexVoronoi", lower_voronoi,
          {float_input("W", 0.0f), float_input("Scale", 5.0f), float_input("Detail", 0.0f),
           float_input("Roughness", 0.5f), float_input("Lacunarity", 2.0f),
           float_input("Smoothness", 1.0f), float_input("Exponent", 0.5f),
           float_input("Randomness", 1.0f)},
          {float_output("Distance"), color_output("Color"), vector_output("Position"),
           float_output("W"), float_output("Radius")},
          {enum_param("voronoi_dimensions", dimension_items()),
           enum_param("feature", {"F1", "F2", "SMOOTH_F1", "DISTANCE_TO_EDGE", "N_SPHERE_RADIUS"}),
           enum_param("distance", {"EUCLIDEAN", "MANHATTAN", "CHEBYCHEV", "MINKOWSKI"}),
           bool_param("normalize", false)}),
  };
  kinds.push_back(
      texture_kind("ShaderNodeTexSky", lower_sky, {}, {color_output("Color")},
                   {enum_param("sky_type", {"MULTIPLE_SCATTERING", "SINGLE_SCATTERING", "PREETHAM",
                                            "HOSEK_WILKIE", "NISHITA"}),
                    floats_param("sun_direction"), float_param("turbidity", 2.2),
                    float_param("ground_albedo", 0.3), bool_param("sun_disc", true),
                    float_param("sun_size", 0.009512), float_param("sun_intensity", 1.0),
                    float_param("sun_elevation", 0.261799), float_param("sun_rotation", 0.0),
                    float_param("altitude", 100.0), float_param("air_density", 1.0),
                    float_param("aerosol_density", 1.0), float_param("dust_density", 1.0),
                    float_param("ozone_density", 1.0)}));
  // White noise is a node without a default coordinate.
  kinds.push_back({"ShaderNodeTexWhiteNoise",
                   NodeRole::kValue,
                   lower_white_noise,
                   {vector_input("Vector"), float_input("W", 0.0f)},
                   {float_output("Value"), color_output("Color")},
                   {enum_param("noise_dimensions", dimension_items())},
                   {}});
  return kinds;
}

}  // namespace vernier
