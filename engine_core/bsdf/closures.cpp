// Adders: from the inputs of Blender's closure nodes to lobes, with the clamps of Cycles.
#include "bsdf/bsdf.h"
#include "bsdf/setup.h"

namespace vernier {

Lobe* Bsdf::add_microfacet(LobeKind kind, Color weight, Vec3f normal, Distribution distribution,
                           float roughness) {
  Lobe* lobe = add(kind, weight, normal);
  if (lobe) {
    lobe->beckmann = distribution == Distribution::kBeckmann;
    lobe->alpha_x = lobe->alpha_y = square(saturate(roughness));
  }
  return lobe;
}

void Bsdf::add_diffuse(Color weight, Vec3f normal, const DiffuseParams& params) {
  const float roughness = saturate(params.roughness);
  const bool rough = roughness >= kLambertRoughness;
  Lobe* lobe = add(rough ? LobeKind::kOrenNayar : LobeKind::kLambert, weight, normal);
  if (lobe && rough) {
    set_oren_nayar(*lobe, roughness, params.color);
  }
}

void Bsdf::add_translucent(Color weight, Vec3f normal) {
  if (Lobe* lobe = add(LobeKind::kLambert, weight, normal)) {
    set_mirrored(*lobe);
  }
}

void Bsdf::add_transparent(Color weight) {
  weight = max(weight, Color{});
  if (average(weight) > 0.0f) {
    transparency += weight;
  }
}

void Bsdf::add_sheen(Color weight, Vec3f normal, float roughness) {
  if (Lobe* lobe = add(LobeKind::kSheen, weight, normal)) {
    lobe->alpha_x = clamp(roughness, 1e-3f, 1.0f);
  }
}

void Bsdf::add_velvet(Color weight, Vec3f normal, float roughness) {
  if (Lobe* lobe = add(LobeKind::kVelvet, weight, normal)) {
    lobe->alpha_x = clamp(roughness, 0.01f, 1.0f);
  }
}

void Bsdf::add_toon(Color weight, Vec3f normal, const ToonParams& params) {
  Lobe* lobe = add(params.glossy ? LobeKind::kGlossyToon : LobeKind::kDiffuseToon, weight, normal);
  if (!lobe) {
    return;
  }
  if (params.glossy) {
    lobe->reflection_bits = kLobeGlossy | kLobeReflection;
  }
  lobe->alpha_x = clamp(params.size, 1e-5f, 1.0f) * (kPi / 2.0f);
  lobe->alpha_y = saturate(params.smooth) * (kPi / 2.0f);
}

void Bsdf::add_glossy(Color weight, Vec3f normal, const GlossyParams& params) {
  const bool shirley = params.distribution == Distribution::kAshikhminShirley;
  Lobe* lobe = add_microfacet(shirley ? LobeKind::kAshikhminShirley : LobeKind::kReflection, weight,
                              normal, params.distribution, params.roughness);
  if (!lobe) {
    return;
  }
  const float anisotropy = clamp(params.anisotropy, -0.99f, 0.99f);
  if (std::abs(anisotropy) > 1e-4f && !is_black(params.tangent)) {
    const float shrink = 1.0f - std::abs(anisotropy);
    const float alpha = lobe->alpha_x;
    lobe->alpha_x = anisotropy < 0.0f ? alpha / shrink : alpha * shrink;
    lobe->alpha_y = anisotropy < 0.0f ? alpha * shrink : alpha / shrink;
    lobe->tangent = rotated_tangent(params.tangent, normal, params.rotation);
  }
  if (shirley) {
    lobe->reflection_bits = kLobeGlossy | kLobeReflection;
    lobe->bumped = false;
    lobe->corrected = !(normal == ng_);
    lobe->alpha_x = clamp(lobe->alpha_x, 1e-4f, 1.0f);
    lobe->alpha_y = clamp(lobe->alpha_y, 1e-4f, 1.0f);
    return;
  }
  finish_microfacet(*lobe, params.distribution == Distribution::kMultiGgx,
                    max(params.color, Color{}));
}

void Bsdf::add_metallic(Color weight, Vec3f normal, const MetallicParams& params) {
  Lobe* lobe =
      add_microfacet(LobeKind::kReflection, weight, normal, params.distribution, params.roughness);
  if (!lobe) {
    return;
  }
  set_anisotropy(*lobe, saturate(params.anisotropy), params.tangent, normal, params.rotation);
  lobe->film = {std::max(params.film.thickness, 0.0f), clamp_ior(params.film.ior)};
  Color average_fresnel;
  if (params.physical) {
    lobe->fresnel = FresnelKind::kConductor;
    lobe->f0 = min(max(params.ior, Color{}), splat(kMaxIor));
    lobe->b = min(max(params.extinction, Color{}), splat(kMaxIor));
    average_fresnel = conductor_average(lobe->f0, lobe->b);
  } else {
    set_f82(*lobe, clamp01(params.base_color), clamp01(params.edge_tint));
    average_fresnel = f82_average(lobe->f0, lobe->b);
  }
  finish_microfacet(*lobe, params.distribution == Distribution::kMultiGgx, average_fresnel);
}

void Bsdf::add_glass(Color weight, Vec3f normal, const GlassParams& params) {
  // Colours above 1 go to the weight, which is capped.
  const Color tint = max(params.color, Color{});
  const float brightness = std::max(max_component(tint), 1.0f);
  Lobe* lobe = add_microfacet(LobeKind::kGlass, weight * brightness, normal, params.distribution,
                              params.roughness);
  if (!lobe) {
    return;
  }
  const float ior = clamp_ior(params.ior);
  set_dielectric(*lobe, ior, backfacing_, params.film);
  lobe->f0 = splat(f0_from_ior(ior));
  lobe->reflection_tint = lobe->transmission_tint = tint / splat(brightness);
  finish_microfacet(*lobe, params.distribution == Distribution::kMultiGgx, tint);
}

void Bsdf::add_refraction(Color weight, Vec3f normal, const RefractionParams& params) {
  Lobe* lobe =
      add_microfacet(LobeKind::kRefraction, weight, normal, params.distribution, params.roughness);
  if (!lobe) {
    return;
  }
  const float ior = clamp_ior(params.ior);
  lobe->eta = backfacing_ ? 1.0f / ior : ior;
  finish_microfacet(*lobe, false, splat(1.0f));
}

}  // namespace vernier
