// Sampling: one lobe is chosen, gives a direction, and all lobes are evaluated for it.
#include "bsdf/bsdf.h"
#include "bsdf/layering.h"
#include "bsdf/lobe_pair.h"
#include "math/warp.h"

namespace vernier {
namespace {

struct Event {
  Vec3f wi;
  bool transmits = false;
  bool valid = false;
};

Vec3f cosine_about(Vec3f n, Vec2f u) { return Frame(n).to_world(square_to_cosine_hemisphere(u)); }

Event sample_microfacet_event(const Lobe& lobe, Vec3f n, Vec3f wo, float u_event, Vec2f u,
                              AllowedEvents allowed) {
  if (!(dot(n, wo) > 0.0f)) {
    return {};
  }
  const Vec3f h = sample_facet(lobe, n, wo, u);
  const float cos_h = dot(h, wo);
  if (!(cos_h > 0.0f)) {
    return {};
  }
  const FresnelSplit fresnel = lobe_fresnel(lobe, cos_h, lobe.eta, lobe.film.ior);
  const AllowedEvents events = facet_events(lobe, allowed);
  const float reflects = reflect_probability(fresnel, events.reflection, events.transmission);
  if (u_event < reflects) {
    const Vec3f wi = reflect(wo, h);
    return {lobe.mirrored ? mirror(wi, n) : wi, lobe.mirrored, dot(n, wi) > 0.0f};
  }
  if (is_black(fresnel.t)) {
    return {};
  }
  const Vec3f wi = refract(wo, h, lobe.eta);
  return {wi, true, dot(n, wi) < 0.0f};
}

Event sample_shirley(const Lobe& lobe, Vec3f n, Vec3f wo, Vec2f u) {
  const float n_x = 2.0f / square(lobe.alpha_x) - 2.0f, n_y = 2.0f / square(lobe.alpha_y) - 2.0f;
  // Ashikhmin and Shirley 2000, equations 9 and 10, over all quadrants at once.
  const float turn = kTwoPi * u.x;
  const float x = std::sqrt(n_y + 1.0f) * std::cos(turn),
              y = std::sqrt(n_x + 1.0f) * std::sin(turn);
  const float length = std::sqrt(x * x + y * y);
  const float cos_phi = x / length, sin_phi = y / length;
  const float exponent = n_x * square(cos_phi) + n_y * square(sin_phi);
  const float log_cos = std::log1p(-u.y) / (exponent + 1.0f);
  const float sin_theta = std::sqrt(-std::expm1(2.0f * log_cos));
  const Frame frame = n_x == n_y ? Frame(n) : Frame(n, lobe.tangent);
  const Vec3f h = frame.to_world({sin_theta * cos_phi, sin_theta * sin_phi, std::exp(log_cos)});
  const Vec3f wi = reflect(wo, h);
  return {wi, false, dot(wo, h) > 0.0f && dot(n, wi) > 0.0f && dot(n, wo) > 0.0f};
}

// A direction of a smooth lobe given wo, on the side that the lobe's densities say: by its shape
// from the camera's side, by the cosine about ng from the light's side (see lobe_pair.h).
Event sample_event(const Lobe& lobe, const LobeSide& seen, Vec3f ng, Vec3f wo, bool radiance,
                   float u_event, Vec2f u, AllowedEvents allowed) {
  const Vec3f n = seen.normal;
  switch (lobe.kind) {
    case LobeKind::kReflection:
    case LobeKind::kGlass:
    case LobeKind::kRefraction:
      return sample_microfacet_event(lobe, n, wo, u_event, u, allowed);
    case LobeKind::kAshikhminShirley:
      return sample_shirley(lobe, n, wo, u);
    case LobeKind::kGlossyToon: {
      const Vec3f axis = reflect(wo, n);
      const Vec3f wi =
          Frame(axis).to_world(square_to_uniform_cone(u, one_minus_cos(toon_cone(lobe))));
      return {wi, false, dot(n, wo) > 0.0f && dot(n, wi) > 0.0f};
    }
    default:
      break;
  }
  if (!radiance) {
    return {cosine_about(lobe.mirrored ? -ng : ng, u), lobe.mirrored, true};
  }
  switch (lobe.kind) {
    case LobeKind::kSheen: {
      const Vec3f wi = sheen_direction(seen.a, seen.b, square_to_cosine_hemisphere(u));
      return {Frame(n, wo).to_world(wi), false, true};
    }
    case LobeKind::kVelvet:
      return {Frame(n).to_world(square_to_uniform_hemisphere(u)), false, true};
    case LobeKind::kDiffuseToon:
      return {Frame(n).to_world(square_to_uniform_cone(u, one_minus_cos(toon_cone(lobe)))), false,
              true};
    default:
      return {cosine_about(lobe.mirrored ? -n : n, u), lobe.mirrored, true};
  }
}

}  // namespace

template <bool kReverse>
std::optional<BsdfSample> Bsdf::sample_transparent(float probability, uint8_t mask) const {
  BsdfSample sample;
  sample.wi = -wo_;
  sample.weight = transparency / probability;
  sample.pdf = probability;
  sample.lobe = kLobeSingular | kLobeTransparent;
  if constexpr (kReverse) {
    RawArray<LobeSide, kMaxLobes> far;
    const float transparent = see_all({-ng_, -wo_, -1.0f}, far);
    sample.pdf_reverse =
        transparent / (mask == kLobeAny ? 1.0f : permitted_total(far, transparent, mask));
  }
  return sample;
}

template <bool kReverse>
std::optional<BsdfSample> Bsdf::sample_singular(int index, float u, float probability,
                                                Transport transport, uint8_t mask) const {
  const Lobe& lobe = lobes_[index];
  const Vec3f n = near_[index].normal;
  const float wo_n = dot(n, wo_);
  if (!(wo_n > 0.0f)) {
    return std::nullopt;
  }
  const AllowedEvents allowed = facet_events(
      lobe, {permits(mask, lobe.reflection_bits), permits(mask, lobe.transmission_bits)});
  const FresnelSplit fresnel = lobe_fresnel(lobe, wo_n, lobe.eta, lobe.film.ior);
  const float reflects = reflect_probability(fresnel, allowed.reflection, allowed.transmission);
  const bool refracts = !(u < reflects);
  const bool transmits = refracts || lobe.mirrored;
  Color f = refracts ? fresnel.t : fresnel.r;
  if (is_black(f)) {
    return std::nullopt;
  }
  BsdfSample sample;
  sample.wi = refracts ? refract(wo_, n, lobe.eta) : (lobe.mirrored ? -wo_ : reflect(wo_, n));
  const float wi_cos = dot(ng_, sample.wi), wi_n = dot(n, sample.wi);
  if (transmits ? !(wi_cos < 0.0f && wi_n < 0.0f) : !(wi_cos > 0.0f && wi_n > 0.0f)) {
    return std::nullopt;
  }
  sample.lobe = transmits ? lobe.transmission_bits : lobe.reflection_bits;
  sample.eta = refracts ? lobe.eta : 1.0f;
  sample.pdf = probability * (refracts ? 1.0f - reflects : reflects);
  if (!(sample.pdf > 0.0f)) {
    return std::nullopt;
  }
  const bool radiance = transport == Transport::kRadiance;
  Color scale = near_[index].scale;
  if (kReverse || !radiance) {
    const float sign = transmits ? -1.0f : 1.0f;
    RawArray<LobeSide, kMaxLobes> far;
    const float transparent = see_all({ng_ * sign, sample.wi, sign}, far);
    // A normal that was corrected for one side's direction scatters elsewhere from the other.
    const bool both_ways = far[index].normal == n * sign;
    if constexpr (kReverse) {
      const float total = mask == kLobeAny ? 1.0f : permitted_total(far, transparent, mask);
      const FresnelSplit back =
          lobe_fresnel(lobe, std::abs(wi_n), eta_from(lobe, sign), film_ior_from(lobe, sign));
      const float back_reflects =
          reflect_probability(back, allowed.reflection, allowed.transmission);
      sample.pdf_reverse =
          total > 0.0f && both_ways
              ? far[index].select / total * (refracts ? 1.0f - back_reflects : back_reflects)
              : 0.0f;
    }
    if (!radiance) {
      if (!both_ways) {
        return std::nullopt;
      }
      // Veach 1997, sections 5.2 and 5.3, for a delta distribution: its change of variables from
      // the camera's to the light's direction brings the cosines at n and the squared indices.
      scale = far[index].scale * (std::abs(wi_cos) / wo_cos_) * (wo_n / std::abs(wi_n)) /
              square(sample.eta);
    }
  }
  sample.weight = f * scale / sample.pdf;
  return sample;
}

template <bool kReverse>
std::optional<BsdfSample> Bsdf::sample_any(float u_lobe, Vec2f u, Transport transport,
                                           uint8_t mask) const {
  const bool radiance = transport == Transport::kRadiance;
  if (lambert_) {
    if (!permits(mask, bits_)) {
      return std::nullopt;
    }
    BsdfSample sample;
    sample.wi = cosine_about(radiance ? lobes_[0].normal : ng_, u);
    const BsdfEval e = eval_lambert<kReverse>(sample.wi, transport, mask);
    if (!(e.pdf > 0.0f)) {
      return std::nullopt;
    }
    // f / pdf without dividing: the ratio is exact.
    sample.weight = lobes_[0].weight;
    if (!radiance) {
      sample.weight *= std::max(dot(lobes_[0].normal, wo_), 0.0f) / wo_cos_;
    }
    sample.pdf = e.pdf;
    sample.pdf_reverse = e.pdf_reverse;
    sample.lobe = bits_;
    return sample;
  }

  const float total = mask == kLobeAny ? 1.0f : permitted_total(near_, transparent_select_, mask);
  if (!(total > 0.0f)) {
    return std::nullopt;
  }
  float r = u_lobe * total;
  int chosen = -1;
  bool passes = permits(mask, kLobeSingular | kLobeTransparent) && transparent_select_ > 0.0f;
  for (int i = 0; i < count_; ++i) {
    const Lobe& lobe = lobes_[i];
    const float select = near_[i].select;
    if (!(select > 0.0f) ||
        !(permits(mask, lobe.reflection_bits) || permits(mask, lobe.transmission_bits))) {
      continue;
    }
    if (chosen >= 0) {
      r -= near_[chosen].select;
    }
    chosen = i;
    if (r < select) {
      passes = false;
      break;
    }
  }
  if (passes) {
    return sample_transparent<kReverse>(transparent_select_ / total, mask);
  }
  if (chosen < 0) {
    return std::nullopt;
  }
  const Lobe& lobe = lobes_[chosen];
  const float u_event = clamp(r / near_[chosen].select, 0.0f, kOneMinusEpsilon);
  if (lobe.singular) {
    return sample_singular<kReverse>(chosen, u_event, near_[chosen].select / total, transport,
                                     mask);
  }
  const AllowedEvents allowed{permits(mask, lobe.reflection_bits),
                              permits(mask, lobe.transmission_bits)};
  const Event event = sample_event(lobe, near_[chosen], ng_, wo_, radiance, u_event, u, allowed);
  if (!event.valid || (dot(ng_, event.wi) < 0.0f) != event.transmits) {
    return std::nullopt;
  }
  const BsdfEval e = eval_all<kReverse>(event.wi, transport, mask);
  if (!(e.pdf > 0.0f)) {
    return std::nullopt;
  }
  BsdfSample sample;
  sample.wi = event.wi;
  sample.weight = e.f / e.pdf;
  sample.pdf = e.pdf;
  sample.pdf_reverse = e.pdf_reverse;
  sample.lobe = event.transmits ? lobe.transmission_bits : lobe.reflection_bits;
  if (event.transmits && !lobe.mirrored) {
    sample.eta = lobe.eta;
  }
  return sample;
}

int Bsdf::singular_events(std::array<BsdfSample, kMaxSingularEvents>& events) const {
  int count = 0;
  const auto keep = [&](const std::optional<BsdfSample>& event) {
    if (event) {
      events[static_cast<size_t>(count++)] = *event;
    }
  };
  // Among the events of one kind alone, each has probability 1.
  constexpr auto kReflections = static_cast<uint8_t>(kLobeAny & ~kLobeTransmission);
  constexpr auto kTransmissions = static_cast<uint8_t>(kLobeAny & ~kLobeReflection);
  for (int i = 0; i < count_; ++i) {
    if (!lobes_[i].singular) {
      continue;
    }
    for (const uint8_t mask : {kReflections, kTransmissions}) {
      if (permits(mask, lobes_[i].reflection_bits) || permits(mask, lobes_[i].transmission_bits)) {
        keep(sample_singular<false>(i, 0.0f, 1.0f, Transport::kRadiance, mask));
      }
    }
  }
  if (!is_black(transparency)) {
    keep(sample_transparent<false>(1.0f, kLobeAny));
  }
  return count;
}

std::optional<BsdfSample> Bsdf::singular_toward(Vec3f wi, uint8_t lobe) const {
  // Refraction near the horizon magnifies the rounding of directions: a milliradian is far more.
  constexpr float kSameDirection = 1e-3f;
  std::optional<BsdfSample> all;
  const auto consider = [&](const std::optional<BsdfSample>& event) {
    if (!event || event->lobe != lobe ||
        length_squared(event->wi - wi) > kSameDirection * kSameDirection) {
      return false;
    }
    const Color weight = event->weight * event->pdf;
    if (all) {
      all->weight += weight;
      all->pdf += event->pdf;
    } else {
      all = event;
      all->weight = weight;
    }
    return true;
  };
  for (int i = 0; i < count_; ++i) {
    if (lobes_[i].singular) {
      // The ends of [0,1) choose reflection and refraction, where both exist.
      const auto event = [&](float u) {
        return sample_singular<false>(i, u, near_[i].select, Transport::kRadiance, kLobeAny);
      };
      if (!consider(event(0.0f))) {
        consider(event(kOneMinusEpsilon));
      }
    }
  }
  if (transparent_select_ > 0.0f) {
    consider(sample_transparent<false>(transparent_select_, kLobeAny));
  }
  return all;
}

std::optional<BsdfSample> Bsdf::sample(float u_lobe, Vec2f u, Transport transport,
                                       uint8_t mask) const {
  return sample_any<true>(u_lobe, u, transport, mask);
}

std::optional<BsdfSample> Bsdf::sample_forward(float u_lobe, Vec2f u, Transport transport,
                                               uint8_t mask) const {
  return sample_any<false>(u_lobe, u, transport, mask);
}

}  // namespace vernier
