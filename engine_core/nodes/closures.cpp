#include "nodes/closures.h"

namespace vernier {
namespace {

// The parameters of one closure.
class Parameters {
 public:
  Parameters(const ClosureList& list, const ClosureCode& closure, const ProgramResult& values)
      : operands_(list.operands.data() + closure.parameters), values_(values) {}

  // What is not a number, after an overflow in the program, is zero.
  float scalar(int i) const { return number(values_[operands_[i]].x); }
  Vec3f vector(int i) const {
    const Vec4f& v = values_[operands_[i]];
    return {number(v.x), number(v.y), number(v.z)};
  }
  Color color(int i) const { return max(vector(i), Color{}); }
  // The zero vector where the socket is not linked to anything.
  Vec3f optional_vector(int i) const { return operands_[i] == kNoOperand ? Vec3f{} : vector(i); }

 private:
  static float number(float v) { return v == v ? v : 0.0f; }

  const Operand* operands_;
  const ProgramResult& values_;
};

Vec3f closure_normal(const ClosureCode& closure, const ProgramResult& values,
                     const SurfacePoint& point) {
  if (closure.normal == kNoOperand) {
    return point.ns;
  }
  const Vec3f n = normalize(values[closure.normal].xyz());
  return is_black(n) ? point.ns : n;
}

PrincipledParams principled_params(const ClosureCode& closure, const Parameters& p) {
  using namespace principled;
  PrincipledParams out;
  out.multi_scatter = closure.distribution == Distribution::kMultiGgx;
  out.thin_wall = p.scalar(kThinWall) != 0.0f;
  out.base_color = p.vector(kBaseColor);
  out.metallic = p.scalar(kMetallic);
  out.roughness = p.scalar(kRoughness);
  out.ior = p.scalar(kIor);
  out.alpha = p.scalar(kAlpha);
  out.diffuse_roughness = p.scalar(kDiffuseRoughness);
  out.subsurface_weight = p.scalar(kSubsurface);
  out.subsurface_anisotropy = p.scalar(kSubsurfaceAnisotropy);
  out.specular_ior_level = p.scalar(kSpecularLevel);
  out.specular_tint = p.vector(kSpecularTint);
  out.anisotropic = p.scalar(kAnisotropic);
  out.anisotropic_rotation = p.scalar(kAnisotropicRotation);
  out.tangent = p.optional_vector(kTangent);
  out.transmission_weight = p.scalar(kTransmission);
  out.coat_weight = p.scalar(kCoat);
  out.coat_roughness = p.scalar(kCoatRoughness);
  out.coat_ior = p.scalar(kCoatIor);
  out.coat_tint = p.vector(kCoatTint);
  out.coat_normal = p.optional_vector(kCoatNormal);
  out.sheen_weight = p.scalar(kSheen);
  out.sheen_roughness = p.scalar(kSheenRoughness);
  out.sheen_tint = p.vector(kSheenTint);
  out.emission_color = p.vector(kEmissionColor);
  out.emission_strength = p.scalar(kEmissionStrength);
  out.film = {p.scalar(kFilmThickness), p.scalar(kFilmIor)};
  return out;
}

MetallicParams metallic_params(const ClosureCode& closure, const Parameters& p) {
  using namespace metallic;
  MetallicParams out;
  out.distribution = closure.distribution;
  out.physical = closure.option;
  (out.physical ? out.ior : out.base_color) = p.vector(kBase);
  (out.physical ? out.extinction : out.edge_tint) = p.vector(kEdge);
  out.roughness = p.scalar(kRoughness);
  out.anisotropy = p.scalar(kAnisotropy);
  out.rotation = p.scalar(kRotation);
  out.tangent = p.optional_vector(kTangent);
  out.film = {p.scalar(kFilmThickness), p.scalar(kFilmIor)};
  return out;
}

}  // namespace

void add_closure(const ClosureList& list, const ClosureCode& closure, const ProgramResult& values,
                 const SurfacePoint& point, Bsdf& bsdf) {
  const float weight = values[closure.weight].x;
  if (!(weight > 0.0f)) {
    return;
  }
  const Parameters p(list, closure, values);
  switch (closure.kind) {
    case ClosureKind::kDiffuse: {
      const Color color = p.color(diffuse::kColor);
      bsdf.add_diffuse(color * weight, closure_normal(closure, values, point),
                       {p.scalar(diffuse::kRoughness), min(color, splat(1.0f))});
      return;
    }
    case ClosureKind::kTranslucent:
      bsdf.add_translucent(p.color(0) * weight, closure_normal(closure, values, point));
      return;
    case ClosureKind::kTransparent:
      bsdf.add_transparent(p.color(0) * weight);
      return;
    case ClosureKind::kGlossy: {
      const Color color = p.color(glossy::kColor);
      bsdf.add_glossy(
          color * weight, closure_normal(closure, values, point),
          {closure.distribution, p.scalar(glossy::kRoughness), p.scalar(glossy::kAnisotropy),
           p.scalar(glossy::kRotation), p.optional_vector(glossy::kTangent), color});
      return;
    }
    case ClosureKind::kMetallic:
      bsdf.add_metallic(splat(weight), closure_normal(closure, values, point),
                        metallic_params(closure, p));
      return;
    case ClosureKind::kGlass:
      bsdf.add_glass(splat(weight), closure_normal(closure, values, point),
                     {closure.distribution,
                      p.color(glass::kColor),
                      p.scalar(glass::kRoughness),
                      p.scalar(glass::kIor),
                      {p.scalar(glass::kFilmThickness), p.scalar(glass::kFilmIor)}});
      return;
    case ClosureKind::kRefraction:
      bsdf.add_refraction(
          p.color(glass::kColor) * weight, closure_normal(closure, values, point),
          {closure.distribution, p.scalar(glass::kRoughness), p.scalar(glass::kIor)});
      return;
    case ClosureKind::kSheen:
      bsdf.add_sheen(p.color(diffuse::kColor) * weight, closure_normal(closure, values, point),
                     p.scalar(diffuse::kRoughness));
      return;
    case ClosureKind::kVelvet:
      bsdf.add_velvet(p.color(diffuse::kColor) * weight, closure_normal(closure, values, point),
                      p.scalar(diffuse::kRoughness));
      return;
    case ClosureKind::kToon:
      bsdf.add_toon(
          p.color(toon::kColor) * weight, closure_normal(closure, values, point),
          {closure.option, saturate(p.scalar(toon::kSize)), saturate(p.scalar(toon::kSmooth))});
      return;
    case ClosureKind::kSubsurface:
      bsdf.add_subsurface(p.color(0) * weight, closure_normal(closure, values, point));
      return;
    case ClosureKind::kPrincipled:
      bsdf.add_principled(splat(weight), closure_normal(closure, values, point),
                          principled_params(closure, p));
      return;
    case ClosureKind::kEmission:
      bsdf.add_emission(p.vector(emission::kColor) * (p.scalar(emission::kStrength) * weight));
      return;
    case ClosureKind::kHoldout:
      bsdf.add_holdout(splat(weight));
      return;
  }
}

Color closure_emission(const ClosureList& list, const ClosureCode& closure,
                       const ProgramResult& values, const SurfacePoint& point) {
  const float weight = values[closure.weight].x;
  const Parameters p(list, closure, values);
  if (closure.kind == ClosureKind::kEmission) {
    return p.vector(emission::kColor) * (p.scalar(emission::kStrength) * weight);
  }
  if (closure.kind != ClosureKind::kPrincipled || !(weight > 0.0f)) {
    return {};
  }
  const bool covered = p.scalar(principled::kCoat) > 0.0f || p.scalar(principled::kSheen) > 0.0f;
  if (!covered) {
    return p.vector(principled::kEmissionColor) * (p.scalar(principled::kEmissionStrength) *
                                                   saturate(p.scalar(principled::kAlpha)) * weight);
  }
  // Coat and sheen absorb by their albedo, which the lobes know.
  Bsdf bsdf;
  bsdf.begin(point);
  add_closure(list, closure, values, point, bsdf);
  return bsdf.emission;
}

Color closure_transparency(const ClosureList& list, const ClosureCode& closure,
                           const ProgramResult& values) {
  const float weight = values[closure.weight].x;
  const Parameters p(list, closure, values);
  switch (closure.kind) {
    case ClosureKind::kTransparent:
      return p.color(0) * std::max(weight, 0.0f);
    case ClosureKind::kPrincipled:
      return splat((1.0f - saturate(p.scalar(principled::kAlpha))) * std::max(weight, 0.0f));
    default:
      return {};
  }
}

}  // namespace vernier
