// The Principled BSDF, version 2 (Blender 4.0 and later), composed as Cycles 5.2 does: from the
// top transparency, sheen, coat, emission; then metal, transmission, and specular over diffuse,
// which share what the layers above leave.
#include "bsdf/bsdf.h"
#include "bsdf/layering.h"
#include "bsdf/setup.h"
#include "bsdf/thin_film.h"

namespace vernier {
namespace {

// Shares at or below this are left out, as in Cycles.
constexpr float kCutoff = 1e-5f;

// Alpha of light that crosses both faces of a rough sheet (Kulla and Conty 2017, page 40, with the
// factor 1.7 for each face).
float thin_transmission_alpha(float alpha, float ior) {
  const float spread = 3.4f * (ior - 1.0f) * square(ior - 0.5f) / (ior * ior * ior);
  return saturate(alpha * safe_sqrt(spread));
}

// Reflection over the base: relative index and reflectance at normal incidence.
struct Specular {
  float eta, f0;
};
Specular specular_level(float ior, float level) {
  const float f0 = f0_from_ior(ior);
  if (level == 0.5f) {
    return {ior, f0};
  }
  const float scaled = f0 * 2.0f * std::max(level, 0.0f);
  const float eta = ior_from_f0(scaled);
  return {ior < 1.0f ? 1.0f / eta : eta, scaled};
}

}  // namespace

// Two lobes that stand for all the reflections between the faces of a sheet.
void Bsdf::add_thin_glass(Color weight, int above, Vec3f normal, const PrincipledParams& params) {
  const float ior = clamp_ior(params.ior);
  const float alpha = square(saturate(params.roughness));
  const Color tint = max(params.specular_tint, Color{});
  for (const bool transmits : {false, true}) {
    Lobe* lobe = add(LobeKind::kReflection, weight, normal);
    if (!lobe) {
      return;
    }
    lobe->above = static_cast<int8_t>(above);
    lobe->thin = true;
    lobe->eta = ior;
    lobe->f0 = min(tint * f0_from_ior(ior), splat(1.0f));
    lobe->reflection_tint = splat(1.0f);
    lobe->transmission_tint = clamp01(params.base_color);
    lobe->film = {std::max(params.film.thickness, 0.0f), clamp_ior(params.film.ior)};
    lobe->alpha_x = lobe->alpha_y = transmits ? thin_transmission_alpha(alpha, ior) : alpha;
    if (transmits) {
      set_mirrored(*lobe);
    }
    finish_microfacet(*lobe, true, transmits ? splat(1.0f) : tint);
  }
}

void Bsdf::add_principled(Color weight, Vec3f normal, const PrincipledParams& params) {
  const float alpha = saturate(params.alpha);
  if (alpha < 1.0f) {
    add_transparent(weight * (1.0f - alpha));
    weight *= alpha;
  }
  int above = -1;  // the lowest layer so far
  const auto place = [this, &above](Lobe* lobe, bool as_layer) {
    if (lobe) {
      lobe->above = static_cast<int8_t>(above);
      lobe->is_layer = as_layer;
      if (as_layer) {
        above = count_ - 1;
      }
    }
  };

  const float coat = std::max(params.coat_weight, 0.0f);
  const Vec3f coat_normal = is_black(params.coat_normal) ? normal : params.coat_normal;
  if (const float sheen = std::max(params.sheen_weight, 0.0f); sheen > kCutoff) {
    const Color tint = max(params.sheen_tint, Color{});
    Vec3f n = coat > 0.0f ? normalize(lerp(normal, coat_normal, saturate(coat))) : normal;
    if (is_black(n)) {
      n = normal;
    }
    if (Lobe* lobe = add(LobeKind::kSheen, weight * tint * sheen, n)) {
      lobe->alpha_x = clamp(params.sheen_roughness, 1e-3f, 1.0f);
      lobe->layer_share = sheen * max_component(tint);
      place(lobe, true);
    }
  }
  if (coat > kCutoff) {
    Lobe* lobe = add_microfacet(LobeKind::kReflection, weight * coat, coat_normal,
                                Distribution::kGgx, params.coat_roughness);
    if (lobe) {
      lobe->fresnel = FresnelKind::kDielectric;
      lobe->eta = clamp(params.coat_ior, 1.0f, kMaxIor);
      lobe->transmission_tint = max(params.coat_tint, Color{});
      lobe->layer_share = coat;
      finish_microfacet(*lobe, true, splat(fresnel_dielectric_average(lobe->eta)));
      place(lobe, true);
    }
  }
  const Color radiance = params.emission_color * params.emission_strength;
  if (!is_black(radiance)) {
    emission += weight * radiance * attenuation(above);
  }

  const Color base = max(params.base_color, Color{});
  const Color clamped_base = min(base, splat(1.0f));
  const Color tint = max(params.specular_tint, Color{});
  const float ior = clamp_ior(params.ior);
  const float anisotropic = saturate(params.anisotropic);
  const ThinFilm film{std::max(params.film.thickness, 0.0f), clamp_ior(params.film.ior)};

  if (const float metallic = saturate(params.metallic); metallic > kCutoff) {
    Lobe* lobe = add_microfacet(LobeKind::kReflection, weight * metallic, normal,
                                Distribution::kGgx, params.roughness);
    if (lobe) {
      set_anisotropy(*lobe, anisotropic, params.tangent, normal, params.anisotropic_rotation);
      set_f82(*lobe, clamped_base, min(tint, splat(1.0f)));
      lobe->film = film;
      finish_microfacet(*lobe, params.multi_scatter, f82_average(lobe->f0, lobe->b));
      place(lobe, false);
    }
    weight *= 1.0f - metallic;
  }
  if (const float transmission = saturate(params.transmission_weight); transmission > kCutoff) {
    if (params.thin_wall) {
      add_thin_glass(weight * transmission, above, normal, params);
    } else if (Lobe* lobe = add_microfacet(LobeKind::kGlass, weight * transmission, normal,
                                           Distribution::kGgx, params.roughness)) {
      set_dielectric(*lobe, ior, backfacing_, film);
      lobe->f0 = min(tint * f0_from_ior(ior), splat(1.0f));
      lobe->reflection_tint = splat(1.0f);
      lobe->transmission_tint = {std::sqrt(clamped_base.x), std::sqrt(clamped_base.y),
                                 std::sqrt(clamped_base.z)};
      finish_microfacet(*lobe, params.multi_scatter, lobe->transmission_tint);
      place(lobe, false);
    }
    weight *= 1.0f - transmission;
  }
  const Specular specular = specular_level(ior, params.specular_ior_level);
  if (specular.eta != 1.0f || film.thickness > kNoFilm) {
    Lobe* lobe =
        add_microfacet(LobeKind::kReflection, weight, normal, Distribution::kGgx, params.roughness);
    if (lobe) {
      set_anisotropy(*lobe, anisotropic, params.tangent, normal, params.anisotropic_rotation);
      lobe->fresnel = FresnelKind::kSchlick;
      lobe->eta = specular.eta;
      lobe->f0 = min(tint * specular.f0, splat(1.0f));
      lobe->reflection_tint = splat(1.0f);
      lobe->film = film;
      const float f0 = f0_from_ior(specular.eta);
      const float blend =
          f0 < 1.0f ? saturate((fresnel_dielectric_average(specular.eta) - f0) / (1.0f - f0))
                    : 1.0f;
      finish_microfacet(*lobe, params.multi_scatter, lerp(lobe->f0, splat(1.0f), blend));
      place(lobe, true);
    }
  }

  const float roughness = saturate(params.diffuse_roughness);
  const bool rough = roughness >= kLambertRoughness;
  const auto diffuse = [&](Color share, Color color) {
    Lobe* lobe = add(LobeKind::kLambert, share, normal);
    place(lobe, false);
    if (lobe && rough) {
      set_oren_nayar(*lobe, roughness, color);
    }
    return lobe;
  };
  const float subsurface = saturate(params.subsurface_weight);
  if (subsurface > kCutoff) {
    const Color share = weight * clamped_base * subsurface;
    if (params.thin_wall) {  // scattered backward and forward in shares of the anisotropy
      const float g = params.subsurface_anisotropy;
      diffuse(share * saturate(0.5f * (1.0f - g)), clamped_base);
      if (Lobe* lobe = diffuse(share * saturate(0.5f * (1.0f + g)), clamped_base)) {
        set_mirrored(*lobe);
      }
    } else {
      Lobe* lobe = add(LobeKind::kLambert, share, normal);
      place(lobe, false);
    }
  }
  diffuse(weight * base * (1.0f - subsurface), base);
}

}  // namespace vernier
