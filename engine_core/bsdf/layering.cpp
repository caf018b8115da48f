#include "bsdf/layering.h"

#include "bsdf/bsdf.h"
#include "bsdf/energy_tables.h"
#include "bsdf/microfacet_lobe.h"
#include "bsdf/normals.h"
#include "bsdf/oren_nayar.h"
#include "bsdf/sheen.h"

namespace vernier {
namespace {

// Share of a microfacet lobe's light that scatters once, seen from a direction.
float single_scattering_energy(const Lobe& lobe, float cos_v, float eta) {
  if (lobe.kind != LobeKind::kGlass) {
    return lookup_2d<EnergyTables::kFine>(energy_tables.reflection.data(), lobe.roughness, cos_v);
  }
  const size_t inside = eta < 1.0f ? 1 : 0;
  return lookup_3d<EnergyTables::kCoarse>(energy_tables.glass[inside].data(), lobe.roughness, cos_v,
                                          lobe.ior_axis);
}
float average_energy(const Lobe& lobe, float eta) {
  if (lobe.kind != LobeKind::kGlass) {
    return lobe.average_energy;
  }
  const size_t inside = eta < 1.0f ? 1 : 0;
  return lookup_2d<EnergyTables::kCoarse>(energy_tables.glass_average[inside].data(),
                                          lobe.roughness, lobe.ior_axis);
}

struct Compensation {
  float energy = 1.0f;  // single scattering scaled up to all
  Color darkening{1.0f, 1.0f,
                  1.0f};  // what the further bounces' Fresnel terms take (of the result)
};

// Kulla and Conty 2017: missing energy spread as the single-scattering lobe, times Fss per bounce.
Compensation compensation(const Lobe& lobe, float cos_v, float eta) {
  const float e = single_scattering_energy(lobe, cos_v, eta);
  if (!(e > 0.0f)) {
    return {};
  }
  const float missing = (1.0f - e) / e;
  Compensation c;
  c.energy = 1.0f + missing;
  if (!(lobe.average_fresnel == splat(1.0f))) {
    const float e_avg = average_energy(lobe, eta);
    const Color fss = lobe.average_fresnel;
    const Color fms = fss * e_avg / (splat(1.0f) - fss * (1.0f - e_avg));
    c.darkening = (splat(1.0f) + fms * missing) / c.energy;
  }
  return c;
}

// A thin dielectric sheet: what both faces reflect and transmit after all inner reflections, with
// absorption along the slanted way (OpenPBR specification 1.1, thin-walled case). Lobe f0 and
// reflection_tint describe one face, transmission_tint the absorption at normal incidence.
FresnelSplit thin_sheet(const Lobe& lobe, float cos_v) {
  Lobe face = lobe;
  face.kind = LobeKind::kGlass;
  face.fresnel = FresnelKind::kSchlick;
  face.transmission_tint = splat(1.0f);
  const float cos_t = safe_sqrt(1.0f - (1.0f - square(cos_v)) / square(lobe.eta));
  if (!(cos_t > 0.0f)) {
    return {face.reflection_tint, {}};
  }
  const FresnelSplit front = lobe_fresnel(face, cos_v, lobe.eta, lobe.film.ior);
  FresnelSplit back = front;
  if (lobe.film.thickness > kNoFilm) {
    back = lobe_fresnel(face, cos_t, 1.0f / lobe.eta, lobe.film.ior / lobe.eta);
  }
  FresnelSplit sheet;
  for (int i = 0; i < 3; ++i) {
    const float c = std::pow(lobe.transmission_tint[i], 1.0f / cos_t);
    const float rest = 1.0f - square(back.r[i] * c);
    sheet.t[i] = rest > 0.0f ? c * front.t[i] * back.t[i] / rest : 0.0f;
    sheet.r[i] = front.r[i] + sheet.t[i] * back.r[i] * c;
  }
  return sheet;
}

// Tint of a coat for light that crosses it obliquely, by Beer's law from its tint at normal
// incidence: tint^(1 / cos of the refracted ray).
Color coat_transmittance(const Lobe& coat, float cos_v) {
  const Color tint = coat.transmission_tint;
  if (tint == splat(1.0f)) {
    return tint;
  }
  const float cos_t = safe_sqrt(1.0f - (1.0f - square(cos_v)) / square(coat.eta));
  const float depth = cos_t > 0.0f ? 1.0f / cos_t : kInfinity;
  Color through;
  for (int i = 0; i < 3; ++i) {
    through[i] = std::min(std::pow(tint[i], depth), kMaxWeight);
  }
  return lerp(splat(1.0f), through, std::min(coat.layer_share, 1.0f));
}

// The part of see_lobe for microfacets. Only where there is a choice between lobes, or something
// lies below, is the albedo of interest.
void see_microfacets(const Lobe& lobe, Color above, const SurfaceSide& side, float cos_v,
                     bool alone, LobeSide& seen, Color& below) {
  const float eta = eta_from(lobe, side.sign);
  if (lobe.thin) {
    const FresnelSplit sheet = thin_sheet(lobe, cos_v);
    seen.scale *= lobe.mirrored ? sheet.t : sheet.r;
  }
  Color darkening = splat(1.0f);
  if (lobe.compensate) {
    const Compensation c = compensation(lobe, cos_v, eta);
    darkening = c.darkening;
    seen.energy = c.energy;
  }
  const Color once = seen.scale * darkening;  // times the albedo of the Fresnel term
  seen.scale = min(once * seen.energy, splat(kMaxWeight));
  if (alone) {
    seen.select = cos_v > 0.0f ? 1.0f : 0.0f;
    return;
  }
  const LobeAlbedo albedo = lobe_albedo(lobe, cos_v, eta, film_ior_from(lobe, side.sign));
  seen.select = cos_v > 0.0f ? std::min(average(once * (albedo.r + albedo.t)), kMaxWeight) : 0.0f;
  if (lobe.is_layer) {
    const float covered = max_component(albedo.r * darkening);
    below = above * saturate(1.0f - lobe.layer_share * covered);
    if (lobe.fresnel == FresnelKind::kDielectric) {
      below *= coat_transmittance(lobe, cos_v);
    }
  }
}

}  // namespace

LobeAlbedo lobe_albedo(const Lobe& lobe, float cos_v, float eta, float film_ior) {
  switch (lobe.kind) {
    case LobeKind::kReflection:
    case LobeKind::kGlass:
    case LobeKind::kRefraction:
      break;
    default:
      return lobe.mirrored ? LobeAlbedo{{}, splat(1.0f)} : LobeAlbedo{splat(1.0f), {}};
  }
  if (lobe.mirrored) {
    return {{}, splat(1.0f)};
  }
  const bool film = lobe.film.thickness > kNoFilm;
  if (!film && (lobe.fresnel == FresnelKind::kSchlick ||
                (lobe.fresnel == FresnelKind::kDielectric && eta > 1.0f))) {
    const float blend = lookup_3d<EnergyTables::kCoarse>(energy_tables.dielectric_blend.data(),
                                                         lobe.roughness, cos_v, lobe.ior_axis);
    if (lobe.fresnel == FresnelKind::kDielectric) {
      return {splat(lerp(f0_from_ior(eta), 1.0f, blend)), {}};
    }
    const Color f = lerp(lobe.f0, splat(1.0f), blend);
    return {f * lobe.reflection_tint, (splat(1.0f) - f) * lobe.transmission_tint};
  }
  if (!film && lobe.fresnel == FresnelKind::kF82) {
    const float blend =
        lookup_2d<EnergyTables::kCoarse>(energy_tables.schlick_blend.data(), lobe.roughness, cos_v);
    return {lerp(lobe.f0, splat(1.0f), blend), {}};
  }
  const FresnelSplit f = lobe_fresnel(lobe, cos_v, eta, film_ior);
  return {f.r, f.t};
}

LobeSide see_lobe(const Lobe& lobe, Color above, const SurfaceSide& side, bool alone,
                  Color& below) {
  LobeSide seen;
  seen.normal = lobe.normal * side.sign;
  if (lobe.corrected) {
    seen.normal = valid_normal(side.ng, side.d, seen.normal);
  }
  const float cos_v = dot(seen.normal, side.d);
  seen.scale = lobe.weight * above;
  seen.energy = 1.0f;
  seen.a = seen.b = 0.0f;
  float covered = 1.0f;  // albedo as a layer
  switch (lobe.kind) {
    case LobeKind::kReflection:
    case LobeKind::kGlass:
    case LobeKind::kRefraction:
      see_microfacets(lobe, above, side, cos_v, alone, seen, below);
      return seen;
    case LobeKind::kOrenNayar:
      seen.a = OrenNayar(lobe.alpha_x).albedo(cos_v);
      break;
    case LobeKind::kSheen: {
      const SheenTransform t = sheen_transform(cos_v, lobe.alpha_x);
      seen.a = t.a, seen.b = t.b;
      seen.scale *= t.albedo;
      covered = t.albedo;
    } break;
    default:
      break;
  }
  seen.scale = min(seen.scale, splat(kMaxWeight));
  seen.select = average(seen.scale);
  if (lobe.is_layer) {
    below = above * saturate(1.0f - lobe.layer_share * covered);
  }
  return seen;
}

}  // namespace vernier
