// Shaders: table and lowering to closures.
#include "nodes/node_tables.h"

namespace vernier {
namespace {

constexpr std::string_view kSubsurfaceFallback =
    "subsurface scattering is replaced by diffuse reflection of the same colour";
constexpr std::string_view kHairFallback = "it is replaced by diffuse reflection of its colour";

void lower_diffuse(NodeLowering& node) {
  node.add_closure(ClosureKind::kDiffuse, {node.input("Color"), node.input("Roughness")}, true);
}
void lower_translucent(NodeLowering& node) {
  node.add_closure(ClosureKind::kTranslucent, {node.input("Color")}, true);
}
void lower_transparent(NodeLowering& node) {
  node.add_closure(ClosureKind::kTransparent, {node.input("Color")}, false);
}
void lower_holdout(NodeLowering& node) { node.add_closure(ClosureKind::kHoldout, {}, false); }

void lower_emission(NodeLowering& node) {
  node.add_closure(ClosureKind::kEmission, {node.input("Color"), node.input("Strength")}, false);
}

// The tangent, which costs a coordinate, is made only where anisotropy may need it.
Value tangent_for(NodeLowering& node, std::string_view anisotropy) {
  return node.builder().is_constant(node.input(anisotropy), 0.0f) ? Value{} : node.input("Tangent");
}

void lower_glossy(NodeLowering& node) {
  enum class Item { kMultiGgx, kGgx, kBeckmann, kAshikhminShirley };
  Distribution distribution = Distribution::kMultiGgx;
  switch (node.param_enum<Item>("distribution")) {
    case Item::kMultiGgx:
      break;
    case Item::kGgx:
      distribution = Distribution::kGgx;
      break;
    case Item::kBeckmann:
      distribution = Distribution::kBeckmann;
      break;
    case Item::kAshikhminShirley:
      distribution = Distribution::kAshikhminShirley;
      break;
  }
  node.add_closure(ClosureKind::kGlossy,
                   {node.input("Color"), node.input("Roughness"), node.input("Anisotropy"),
                    node.input("Rotation"), tangent_for(node, "Anisotropy")},
                   true, distribution);
}

Distribution microfacets(NodeLowering& node) {
  enum class Item { kMultiGgx, kGgx, kBeckmann };
  switch (node.param_enum<Item>("distribution")) {
    case Item::kMultiGgx:
      return Distribution::kMultiGgx;
    case Item::kGgx:
      return Distribution::kGgx;
    case Item::kBeckmann:
      break;
  }
  return Distribution::kBeckmann;
}

void lower_metallic(NodeLowering& node) {
  enum class Item { kF82, kPhysical };
  const bool physical = node.param_enum<Item>("fresnel_type") == Item::kPhysical;
  node.add_closure(
      ClosureKind::kMetallic,
      {node.input(physical ? "IOR" : "Base Color"),
       node.input(physical ? "Extinction" : "Edge Tint"), node.input("Roughness"),
       node.input("Anisotropy"), node.input("Rotation"), tangent_for(node, "Anisotropy"),
       node.input("Thin Film Thickness"), node.input("Thin Film IOR")},
      true, microfacets(node), physical);
}

void lower_glass(NodeLowering& node) {
  node.add_closure(ClosureKind::kGlass,
                   {node.input("Color"), node.input("Roughness"), node.input("IOR"),
                    node.input("Thin Film Thickness"), node.input("Thin Film IOR")},
                   true, microfacets(node));
}

void lower_refraction(NodeLowering& node) {
  enum class Item { kBeckmann, kGgx };
  const bool beckmann = node.param_enum<Item>("distribution") == Item::kBeckmann;
  node.add_closure(ClosureKind::kRefraction,
                   {node.input("Color"), node.input("Roughness"), node.input("IOR")}, true,
                   beckmann ? Distribution::kBeckmann : Distribution::kGgx);
}

void lower_sheen(NodeLowering& node) {
  enum class Item { kMicrofiber, kAshikhmin };
  const bool velvet = node.param_enum<Item>("distribution") == Item::kAshikhmin;
  node.add_closure(velvet ? ClosureKind::kVelvet : ClosureKind::kSheen,
                   {node.input("Color"), node.input("Roughness")}, true);
}

void lower_toon(NodeLowering& node) {
  enum class Item { kDiffuse, kGlossy };
  node.add_closure(ClosureKind::kToon,
                   {node.input("Color"), node.input("Size"), node.input("Smooth")}, true,
                   Distribution::kGgx, node.param_enum<Item>("component") == Item::kGlossy);
}

void lower_subsurface(NodeLowering& node) {
  node.add_closure(ClosureKind::kSubsurface, {node.input("Color")}, true);
}

void lower_hair(NodeLowering& node) {
  node.add_closure(ClosureKind::kDiffuse, {node.input("Color"), node.builder().constant(0.0f)},
                   false);
}

void lower_principled(NodeLowering& node) {
  enum class Item { kMultiGgx, kGgx };
  ProgramBuilder& builder = node.builder();
  const Value subsurface = node.input("Subsurface Weight");
  if (!builder.is_constant(subsurface, 0.0f)) {
    node.warn(std::string(kSubsurfaceFallback));
  }
  const bool multi = node.param_enum<Item>("distribution") == Item::kMultiGgx;
  node.add_closure(ClosureKind::kPrincipled,
                   {node.input("Base Color"),
                    node.input("Metallic"),
                    node.input("Roughness"),
                    node.input("IOR"),
                    node.input("Alpha"),
                    node.input("Thin Wall"),
                    node.input("Diffuse Roughness"),
                    subsurface,
                    node.input("Subsurface Anisotropy"),
                    node.input("Specular IOR Level"),
                    node.input("Specular Tint"),
                    node.input("Anisotropic"),
                    node.input("Anisotropic Rotation"),
                    tangent_for(node, "Anisotropic"),
                    node.input("Transmission Weight"),
                    node.input("Coat Weight"),
                    node.input("Coat Roughness"),
                    node.input("Coat IOR"),
                    node.input("Coat Tint"),
                    node.linked_input("Coat Normal"),
                    node.input("Sheen Weight"),
                    node.input("Sheen Roughness"),
                    node.input("Sheen Tint"),
                    node.input("Emission Color"),
                    node.input("Emission Strength"),
                    node.input("Thin Film Thickness"),
                    node.input("Thin Film IOR")},
                   true, multi ? Distribution::kMultiGgx : Distribution::kGgx);
}

InputKind normal_input(std::string_view name = "Normal") {
  return vector_input(name, SocketSource::kNormal);
}
InputKind tangent_input() { return vector_input("Tangent", SocketSource::kTangent); }

NodeKind closure_kind(std::string_view name, void (*lower)(NodeLowering&),
                      std::vector<InputKind> inputs, std::vector<ParamKind> params = {},
                      std::string_view output = "BSDF", std::string_view fallback = {}) {
  return {name,
          NodeRole::kClosure,
          lower,
          std::move(inputs),
          {shader_output(output)},
          std::move(params),
          fallback};
}

std::vector<InputKind> principled_inputs() {
  return {color_input("Base Color", 0.8f),
          float_input("Metallic", 0.0f),
          float_input("Roughness", 0.5f),
          float_input("IOR", 1.5f),
          float_input("Alpha", 1.0f),
          float_input("Thin Wall", 0.0f),
          normal_input(),
          float_input("Diffuse Roughness", 0.0f),
          float_input("Subsurface Weight", 0.0f),
          vector_input("Subsurface Radius", 1, 0.2f, 0.1f),
          float_input("Subsurface Scale", 0.05f),
          float_input("Subsurface IOR", 1.4f),
          float_input("Subsurface Anisotropy", 0.0f),
          float_input("Specular IOR Level", 0.5f),
          color_input("Specular Tint", 1.0f),
          float_input("Anisotropic", 0.0f),
          float_input("Anisotropic Rotation", 0.0f),
          tangent_input(),
          float_input("Transmission Weight", 0.0f),
          float_input("Coat Weight", 0.0f),
          float_input("Coat Roughness", 0.03f),
          float_input("Coat IOR", 1.5f),
          color_input("Coat Tint", 1.0f),
          normal_input("Coat Normal"),
          float_input("Sheen Weight", 0.0f),
          float_input("Sheen Roughness", 0.5f),
          color_input("Sheen Tint", 1.0f),
          color_input("Emission Color", 1.0f),
          float_input("Emission Strength", 0.0f),
          float_input("Thin Film Thickness", 0.0f),
          float_input("Thin Film IOR", 1.33f)};
}

std::vector<ParamKind> microfacet_params() {
  return {enum_param("distribution", {"MULTI_GGX", "GGX", "BECKMANN"})};
}

ParamKind scattering_method(std::string_view name) {
  return enum_param(name, {"RANDOM_WALK", "BURLEY", "RANDOM_WALK_SKIN", "RANDOM_WALK_LEGACY"});
}

std::vector<NodeKind> mixing_kinds() {
  return {{"ShaderNodeMixShader",
           NodeRole::kMixShader,
           nullptr,
           {float_input("Fac", 0.5f), shader_input("Shader"), shader_input("Shader_001")},
           {shader_output("Shader")},
           {},
           {}},
          {"ShaderNodeAddShader",
           NodeRole::kAddShader,
           nullptr,
           {shader_input("Shader"), shader_input("Shader_001")},
           {shader_output("Shader")},
           {},
           {}}};
}

}  // namespace

std::vector<NodeKind> closure_node_kinds() {
  std::vector<NodeKind> kinds = mixing_kinds();
  for (NodeKind& kind : std::vector<NodeKind>{
           closure_kind("ShaderNodeBsdfPrincipled", lower_principled, principled_inputs(),
                        {enum_param("distribution", {"MULTI_GGX", "GGX"}),
                         scattering_method("subsurface_method")}),
           closure_kind(
               "ShaderNodeBsdfDiffuse", lower_diffuse,
               {color_input("Color", 0.8f), float_input("Roughness", 0.0f), normal_input()}),
           closure_kind(
               "ShaderNodeBsdfAnisotropic", lower_glossy,
               {color_input("Color", 0.8f), float_input("Roughness", 0.5f),
                float_input("Anisotropy", 0.0f), float_input("Rotation", 0.0f), normal_input(),
                tangent_input()},
               {enum_param("distribution", {"MULTI_GGX", "GGX", "BECKMANN", "ASHIKHMIN_SHIRLEY"})}),
           closure_kind(
               "ShaderNodeBsdfMetallic", lower_metallic,
               {color_input("Base Color", 0.617f, 0.577f, 0.540f),
                color_input("Edge Tint", 0.695f, 0.726f, 0.770f),
                vector_input("IOR", 2.757f, 2.513f, 2.231f),
                vector_input("Extinction", 3.867f, 3.404f, 3.009f), float_input("Roughness", 0.5f),
                float_input("Anisotropy", 0.0f), float_input("Rotation", 0.0f), normal_input(),
                tangent_input(), float_input("Thin Film Thickness", 0.0f),
                float_input("Thin Film IOR", 1.33f)},
               {enum_param("distribution", {"MULTI_GGX", "GGX", "BECKMANN"}),
                enum_param("fresnel_type", {"F82", "PHYSICAL_CONDUCTOR"})}),
           closure_kind(
               "ShaderNodeBsdfGlass", lower_glass,
               {color_input("Color", 1.0f), float_input("Roughness", 0.0f),
                float_input("IOR", 1.5f), normal_input(), float_input("Thin Film Thickness", 0.0f),
                float_input("Thin Film IOR", 1.33f)},
               microfacet_params()),
           closure_kind("ShaderNodeBsdfRefraction", lower_refraction,
                        {color_input("Color", 1.0f), float_input("Roughness", 0.0f),
                         float_input("IOR", 1.45f), normal_input()},
                        {enum_param("distribution", {"BECKMANN", "GGX"})}),
           closure_kind("ShaderNodeBsdfTranslucent", lower_translucent,
                        {color_input("Color", 0.8f), normal_input()}),
           closure_kind("ShaderNodeBsdfTransparent", lower_transparent,
                        {color_input("Color", 1.0f)}),
           closure_kind(
               "ShaderNodeBsdfSheen", lower_sheen,
               {color_input("Color", 0.8f), float_input("Roughness", 0.5f), normal_input()},
               {enum_param("distribution", {"MICROFIBER", "ASHIKHMIN"})}),
           closure_kind("ShaderNodeBsdfToon", lower_toon,
                        {color_input("Color", 0.8f), float_input("Size", 0.5f),
                         float_input("Smooth", 0.0f), normal_input()},
                        {enum_param("component", {"DIFFUSE", "GLOSSY"})}),
           closure_kind(
               "ShaderNodeSubsurfaceScattering", lower_subsurface,
               {color_input("Color", 0.8f), float_input("Scale", 0.05f),
                vector_input("Radius", 1, 0.2f, 0.1f), float_input("IOR", 1.4f),
                float_input("Roughness", 1.0f), float_input("Anisotropy", 0.0f), normal_input()},
               {scattering_method("falloff")}, "BSSRDF", kSubsurfaceFallback),
           closure_kind("ShaderNodeEmission", lower_emission,
                        {color_input("Color", 1.0f), float_input("Strength", 1.0f)}, {},
                        "Emission"),
           closure_kind("ShaderNodeBackground", lower_emission,
                        {color_input("Color", 0.8f), float_input("Strength", 1.0f)}, {},
                        "Background"),
           closure_kind("ShaderNodeHoldout", lower_holdout, {}, {}, "Holdout"),
           closure_kind(
               "ShaderNodeBsdfHair", lower_hair,
               {color_input("Color", 0.8f), float_input("Offset", 0.0f),
                float_input("RoughnessU", 0.1f), float_input("RoughnessV", 1.0f), tangent_input()},
               {enum_param("component", {"Reflection", "Transmission"})}, "BSDF", kHairFallback),
       }) {
    kinds.push_back(std::move(kind));
  }
  return kinds;
}

}  // namespace vernier
