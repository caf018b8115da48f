// Value and densities of all smooth lobes for a pair of directions.
#include "bsdf/bsdf.h"
#include "bsdf/layering.h"
#include "bsdf/lobe_pair.h"

namespace vernier {
float Bsdf::permitted_total(const RawArray<LobeSide, kMaxLobes>& seen, float transparent,
                            uint8_t mask) const {
  float total = permits(mask, kLobeSingular | kLobeTransparent) ? transparent : 0.0f;
  for (int i = 0; i < count_; ++i) {
    if (permits(mask, lobes_[i].reflection_bits) || permits(mask, lobes_[i].transmission_bits)) {
      total += seen[i].select;
    }
  }
  return total;
}

template <bool kReverse>
BsdfEval Bsdf::eval_all(Vec3f wi, Transport transport, uint8_t mask) const {
  const float wi_cos = dot(ng_, wi);
  if (wi_cos == 0.0f || !smooth_) {
    return {};
  }
  const bool transmit = wi_cos < 0.0f;
  const bool radiance = transport == Transport::kRadiance;
  const float sign = transmit ? -1.0f : 1.0f;
  const SurfaceSide near_side{ng_, wo_, 1.0f}, far_side{ng_ * sign, wi, sign};

  float near_total = 1.0f, far_total = 1.0f;
  RawArray<LobeSide, kMaxLobes> far;
  float far_transparent = 0.0f;
  if (kReverse || !radiance) {
    far_transparent = see_all(far_side, far);
  }
  if (mask != kLobeAny) {
    near_total = permitted_total(near_, transparent_select_, mask);
    if (kReverse || !radiance) {
      far_total = permitted_total(far, far_transparent, mask);
    }
  }

  const SurfaceSide& camera = radiance ? near_side : far_side;
  const SurfaceSide& light = radiance ? far_side : near_side;
  BsdfEval result;
  float pdf_light = 0.0f, pdf_camera = 0.0f;
  for (int i = 0; i < count_; ++i) {
    const Lobe& lobe = lobes_[i];
    const AllowedEvents allowed{permits(mask, lobe.reflection_bits),
                                permits(mask, lobe.transmission_bits)};
    if (lobe.singular || !(transmit ? allowed.transmission : allowed.reflection)) {
      continue;
    }
    const LobeSide& seen = radiance ? near_[i] : far[i];
    LobePair pair = evaluate_lobe(lobe, seen, camera, light, ns_, transmit, allowed);
    result.f += pair.f * seen.scale;
    pdf_light += pair.pdf_s * seen.select;
    if (kReverse || !radiance) {
      const LobeSide& other = radiance ? far[i] : near_[i];
      if (depends_on_side(lobe, transmit, seen.normal, other.normal)) {
        pair.pdf_g = evaluate_lobe(lobe, other, light, camera, ns_, transmit, allowed).pdf_s;
      }
      pdf_camera += pair.pdf_g * other.select;
    }
  }
  if (radiance) {
    result.pdf = near_total > 0.0f ? pdf_light / near_total : 0.0f;
    if constexpr (kReverse) {
      result.pdf_reverse = far_total > 0.0f ? pdf_camera / far_total : 0.0f;
    }
  } else {
    result.f *= std::abs(wi_cos) / wo_cos_;  // Veach 1997, section 5.3
    result.pdf = near_total > 0.0f ? pdf_camera / near_total : 0.0f;
    if constexpr (kReverse) {
      result.pdf_reverse = far_total > 0.0f ? pdf_light / far_total : 0.0f;
    }
  }
  return result;
}

float Bsdf::diffuse_share(Vec3f wi, Transport transport) const {
  if (lambert_) {
    return 1.0f;
  }
  const bool radiance = transport == Transport::kRadiance;
  const SurfaceSide near_side{ng_, wo_, 1.0f}, far_side{ng_, wi, 1.0f};
  RawArray<LobeSide, kMaxLobes> far;
  if (!radiance) {
    see_all(far_side, far);
  }
  const SurfaceSide& camera = radiance ? near_side : far_side;
  const SurfaceSide& light = radiance ? far_side : near_side;
  float diffuse = 0.0f, total = 0.0f;
  for (int i = 0; i < count_; ++i) {
    const Lobe& lobe = lobes_[i];
    if (lobe.singular || lobe.reflection_bits == 0) {
      continue;
    }
    const LobeSide& seen = radiance ? near_[i] : far[i];
    const float pdf =
        evaluate_lobe(lobe, seen, camera, light, ns_, false, {true, true}).pdf_s * seen.select;
    total += pdf;
    diffuse += (lobe.reflection_bits & kLobeDiffuse) != 0 ? pdf : 0.0f;
  }
  return total > 0.0f ? diffuse / total : 0.0f;
}

template BsdfEval Bsdf::eval_all<false>(Vec3f, Transport, uint8_t) const;
template BsdfEval Bsdf::eval_all<true>(Vec3f, Transport, uint8_t) const;

}  // namespace vernier
