// The scattering of light at one surface point: a weighted sum of lobes, plus emission.
//
// Conventions. `wo` is the given direction, `wi` the sampled one; both are unit, in render space,
// and point away from the surface. With Transport::kRadiance the path comes from the camera and wo
// is the camera's side; with kImportance it comes from a light and wi is the camera's side.
//
// Layering (coat, sheen, specular over diffuse) attenuates by the albedo that the *camera's* side
// sees, as Cycles does, so the sum is not reciprocal. eval() honours that in both modes: the same
// pair of directions gives the same scattering whichever end was sampled. Densities depend on the
// given direction and the mode alone.
//
// A lobe implements one function of (camera side c, light side l): F(c, l), which includes the
// cosine at l. What makes transport non-symmetric is applied here, once. With kRadiance eval()
// gives F(wo, wi). With kImportance it gives F(wi, wo) |wi.ng| / |wo.ng|, which for one lobe of
// normal ns is f |wi.ns| times Veach's factor |wo.ns wi.ng| / |wo.ng wi.ns| (Veach 1997, section
// 5.3). As in Cycles, paths carry radiance over the squared index of refraction (basic radiance,
// section 5.2): sampled refraction has weight 1 with kRadiance, and the squared index of wo's side
// over that of wi's side with kImportance.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "bsdf/lobe.h"
#include "bsdf/params.h"
#include "math/frame.h"
#include "math/vec.h"
#include "scene/surface_point.h"

namespace vernier {

struct SurfaceSide;

enum class Transport : uint8_t { kRadiance, kImportance };

// What a lobe is. Also the mask by which passes and bounce limits select: a scattering event is
// selected where the mask has all of its bits. (A glass lobe makes two kinds of events.)
enum LobeBits : uint8_t {
  kLobeDiffuse = 1u << 0,
  kLobeGlossy = 1u << 1,
  kLobeReflection = 1u << 2,
  kLobeTransmission = 1u << 3,  // to the other side of the surface
  kLobeSingular = 1u << 4,      // a delta distribution: never part of eval()
  kLobeTransparent = 1u << 5,   // straight through, undeviated (with kLobeSingular)
  kLobeAny = 0xff,
};

// Whether a mask selects the events of these bits (0: there are none).
constexpr bool permits(uint8_t mask, uint8_t bits) { return bits != 0 && (bits & ~mask) == 0; }

// f includes |cos(wi, ns)| and all adjoint factors. Densities are per solid angle.
struct BsdfEval {
  Color f;
  float pdf = 0;          // of sampling wi given wo
  float pdf_reverse = 0;  // of sampling wo given wi, by a path of the other transport mode
};

struct BsdfSample {
  Vec3f wi;
  Color weight;   // f / pdf, over all lobes (singular: the sampled lobe's ratio)
  float pdf = 0;  // solid angle; singular: the probability of the choice of the lobe
  float pdf_reverse = 0;
  float eta = 1;     // index of the side wi is on over that of wo's side
  uint8_t lobe = 0;  // LobeBits of the sampled event
};

class Bsdf {
 public:
  // More than these and the weakest are dropped. (A Principled has at most eight.)
  static constexpr int kMaxLobes = 12;

  Bsdf() {}

  // Starts over at a point. Lobes see wo, ng, ns and the side of the surface from here.
  void begin(const SurfacePoint& point) {
    emission = transparency = holdout = Color{};
    ng_ = point.ng;
    ns_ = point.ns;
    wo_ = point.wo;
    wo_cos_ = std::max(dot(ng_, wo_), kUnitRoundoff);
    backfacing_ = point.backfacing;
    transparent_select_ = 0.0f;
    count_ = overflow_ = 0;
    bits_ = 0;
    smooth_ = lambert_ = false;
  }

  // In place of the adders, for a material that is the same everywhere: takes over what they made
  // at another point, on the same side of the surface and with its shading normal for all lobes.
  // Emission is not taken over: what covers it depends on the direction.
  void reuse(const Bsdf& prepared);

  // Adders. `weight` is linear RGB, not negative, and holds the node's colour (except where the
  // parameters say otherwise) times its share in the mix. `normal` is unit, on the side of ng.
  // Weights below 1e-5 on average add nothing, as in Cycles.
  void add_diffuse(Color weight, Vec3f normal, const DiffuseParams& params = {});
  void add_translucent(Color weight, Vec3f normal);
  void add_transparent(Color weight);
  void add_glossy(Color weight, Vec3f normal, const GlossyParams& params);
  void add_metallic(Color weight, Vec3f normal, const MetallicParams& params);
  void add_glass(Color weight, Vec3f normal, const GlassParams& params);
  void add_refraction(Color weight, Vec3f normal, const RefractionParams& params);
  void add_sheen(Color weight, Vec3f normal, float roughness);   // microfibre
  void add_velvet(Color weight, Vec3f normal, float roughness);  // Ashikhmin
  void add_toon(Color weight, Vec3f normal, const ToonParams& params);
  // Subsurface scattering's stated fallback: diffuse reflection.
  void add_subsurface(Color weight, Vec3f normal) { add_diffuse(weight, normal); }
  void add_principled(Color weight, Vec3f normal, const PrincipledParams& params);
  // Emission and Background nodes: radiance toward wo.
  void add_emission(Color radiance) { emission += radiance; }
  void add_holdout(Color weight) { holdout += weight; }

  // To be called once after the last adder and before any of the following.
  void finish();

  // Smooth lobes only. wi may be any unit vector.
  BsdfEval eval(Vec3f wi, Transport transport, uint8_t mask = kLobeAny) const;
  // The same without pdf_reverse (which is left 0): what a path tracer needs, and cheaper.
  BsdfEval eval_forward(Vec3f wi, Transport transport, uint8_t mask = kLobeAny) const;

  // Where light is reflected between wo and wi: the part that diffuse lobes have in the density
  // from the camera's side. 0 where nothing scatters so.
  float diffuse_share(Vec3f wi, Transport transport) const;

  // u_lobe and u in [0,1). Empty: the path ends here (the sample fell below the surface, or there
  // is nothing to sample): part of the estimate, with contribution zero.
  std::optional<BsdfSample> sample(float u_lobe, Vec2f u, Transport transport,
                                   uint8_t mask = kLobeAny) const;
  // The same without pdf_reverse.
  std::optional<BsdfSample> sample_forward(float u_lobe, Vec2f u, Transport transport,
                                           uint8_t mask = kLobeAny) const;

  // All delta distributions at once, transparency included: what deterministic ray tracing follows.
  // `weight` is the full ratio of each (nothing is chosen: pdf is 1). Returns their number.
  static constexpr int kMaxSingularEvents = 2 * kMaxLobes + 1;
  int singular_events(std::array<BsdfSample, kMaxSingularEvents>& events) const;

  // The delta distributions with the bits `lobe` that scatter to wi, all together: with kRadiance,
  // `pdf` the probability of their choice and `weight` the full ratio. Empty: there is none.
  std::optional<BsdfSample> singular_toward(Vec3f wi, uint8_t lobe) const;

  // Union of the bits of what may be sampled.
  uint8_t lobes() const { return bits_; }
  // True where eval() can be other than zero: some lobe is not singular.
  bool connectible() const { return smooth_; }
  // Estimate of the directional albedo toward wo of events within the mask (colour passes).
  Color albedo(uint8_t mask = kLobeAny) const;
  // Mean squared roughness (alpha_x alpha_y; singular 0, diffuse 1) over sampling weights, as
  // Cycles' guiding and filters use: below 0.01 or so the surface is near specular.
  float mean_squared_roughness() const;
  // Of the smooth lobes the widest, by its narrower side: alpha of microfacets, 1 of all others; 0
  // where there is none. (Not the lobes' shares, which depend on the direction.)
  float widest_alpha() const;
  // The least squared roughness (as above) of a lobe that is not diffuse; infinite without any.
  float sharpest_glossy() const;
  // The lobes' normals averaged over their sampling weights, unit; ns where there are none.
  Vec3f mean_normal() const;
  // How many lobes were dropped because there was no room.
  int overflow() const { return overflow_; }

  Color emission;      // radiance toward wo
  Color transparency;  // weight of what passes straight through
  Color holdout;       // weight that makes the film transparent

 private:
  Lobe* add(LobeKind kind, Color weight, Vec3f normal);
  Lobe* add_microfacet(LobeKind kind, Color weight, Vec3f normal, Distribution distribution,
                       float roughness);
  void add_thin_glass(Color weight, int above, Vec3f normal, const PrincipledParams& params);
  void drop(int index);
  Color attenuation(int layer) const;
  float see_all(const SurfaceSide& side, RawArray<LobeSide, kMaxLobes>& seen) const;
  float permitted_total(const RawArray<LobeSide, kMaxLobes>& seen, float transparent,
                        uint8_t mask) const;
  template <bool kReverse>
  BsdfEval eval_lambert(Vec3f wi, Transport transport, uint8_t mask) const;
  template <bool kReverse>
  BsdfEval eval_all(Vec3f wi, Transport transport, uint8_t mask) const;
  template <bool kReverse>
  std::optional<BsdfSample> sample_any(float u_lobe, Vec2f u, Transport transport,
                                       uint8_t mask) const;
  template <bool kReverse>
  std::optional<BsdfSample> sample_singular(int index, float u, float probability,
                                            Transport transport, uint8_t mask) const;
  template <bool kReverse>
  std::optional<BsdfSample> sample_transparent(float probability, uint8_t mask) const;

  Vec3f ng_, ns_, wo_;
  float wo_cos_ = 1;  // wo.ng, at least its rounding error
  float transparent_select_ = 0;
  int count_ = 0;
  int overflow_ = 0;
  uint8_t bits_ = 0;
  bool backfacing_ = false;
  bool smooth_ = false;
  bool lambert_ = false;  // nothing but one plain diffuse lobe
  RawArray<Lobe, kMaxLobes> lobes_;
  RawArray<LobeSide, kMaxLobes> near_;  // from wo's side
};

// The commonest surface: one plain diffuse lobe.
template <bool kReverse>
inline BsdfEval Bsdf::eval_lambert(Vec3f wi, Transport transport, uint8_t mask) const {
  const float wi_cos = dot(ng_, wi);
  const Lobe& lobe = lobes_[0];
  const bool radiance = transport == Transport::kRadiance;
  const float light_cos = dot(lobe.normal, radiance ? wi : wo_);
  if (!(wi_cos > 0.0f) || !permits(mask, bits_)) {
    return {};
  }
  const float along = std::max(light_cos, 0.0f) * kInvPi;
  BsdfEval result;
  result.f = lobe.weight * (radiance ? along : along * (wi_cos / wo_cos_));
  result.pdf = radiance ? along : wi_cos * kInvPi;
  if constexpr (kReverse) {
    result.pdf_reverse = radiance ? wo_cos_ * kInvPi : along;
  }
  return result;
}

inline BsdfEval Bsdf::eval(Vec3f wi, Transport transport, uint8_t mask) const {
  return lambert_ ? eval_lambert<true>(wi, transport, mask) : eval_all<true>(wi, transport, mask);
}

inline BsdfEval Bsdf::eval_forward(Vec3f wi, Transport transport, uint8_t mask) const {
  return lambert_ ? eval_lambert<false>(wi, transport, mask) : eval_all<false>(wi, transport, mask);
}

}  // namespace vernier
