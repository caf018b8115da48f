// A vertex of a path on a surface, and how light scatters there.
#pragma once

#include <cmath>
#include <optional>

#include "bsdf/bsdf.h"
#include "nodes/material.h"
#include "paths/mis.h"
#include "scene/scene.h"
#include "scene/surface_point.h"

namespace vernier {

// Made by a sub-path that arrives along -point.wo. It is the whole of what a connection needs.
struct PathVertex {
  SurfacePoint point;
  Bsdf bsdf;   // closures as seen along point.wo
  Color beta;  // throughput up to here: before scattering, with all densities divided out
  MisState mis;
  uint32_t parent = kNoIndex;  // the vertex before, in its Subpath; kNoIndex: the sub-path's start
  Transport mode = Transport::kRadiance;
  const MaterialTraits* traits = nullptr;
  bool other_reaches = true;  // sub-paths from the other side may contain this vertex
};

// |cos| with the geometric normal. At least its rounding error: densities are divided by it.
inline float abs_cosine(Vec3f ng, Vec3f w) { return std::max(std::abs(dot(ng, w)), kUnitRoundoff); }
inline float abs_cosine(const SurfacePoint& point, Vec3f w) { return abs_cosine(point.ng, w); }

// What makes light's flux over area, from direction w, radiance at `point` (Jensen 2001,
// section 7): the cosine with the surface as it is, at the point or where the light arrived nearby,
// whose cosine is `there`. The larger one, or what grazes one facet of a curved surface and not
// another would be divided by next to nothing.
inline float flux_cosine(const SurfacePoint& point, Vec3f w, float there) {
  return std::max(abs_cosine(point, w), there);
}

// The closures at `point` as seen along wo.
inline void evaluate_bsdf(const Scene& scene, const SurfacePoint& point, Bsdf& bsdf) {
  bsdf.begin(point);
  scene.materials[point.material]->evaluate(point, bsdf);
  bsdf.finish();
}

// The same point met from direction w instead of wo.
inline SurfacePoint seen_from(const SurfacePoint& point, Vec3f w) {
  SurfacePoint other = point;
  other.wo = w;
  if (dot(w, point.ng) < 0.0f) {
    other.ng = -point.ng;
    other.ns = -point.ns;
    other.backfacing = !point.backfacing;
  }
  return other;
}

// The order of magnitude of a vertex's BSDF: what reflects into a solid angle in proportion to its
// squared roughness is as much brighter there. Sharper lobes than kSharpest hardly ever point at
// what they are joined to: then to count them brighter would only cost evaluations.
inline float brightness(const PathVertex& v) {
  constexpr float kSharpest = 1e-3f;
  return kInvPi / std::max(v.bsdf.mean_squared_roughness(), kSharpest);
}

// Whether closures as seen from wi are others than those that are seen from wo.
inline bool differs_from(const PathVertex& v, Vec3f wi) {
  return v.traits->direction_dependent || v.traits->path_dependent ||
         (v.traits->side_dependent && dot(v.point.ng, wi) < 0.0f);
}

// The bits of all lobes that `bsdf`, of the closures at `point`, may have as seen from anywhere:
// what densities depend on that paths from either side must agree on.
inline uint8_t lobes_of_both_sides(const Scene& scene, const SurfacePoint& point,
                                   const Bsdf& bsdf) {
  const MaterialTraits& traits = scene.materials[point.material]->traits();
  const bool varies = traits.side_dependent || traits.direction_dependent || traits.path_dependent;
  return varies ? traits.lobes : bsdf.lobes();
}

// Scattering between point.wo and wi, smooth lobes only; f, pdf and pdf_reverse as Bsdf has them
// for the vertex's mode. Closures that depend on the viewer are those that the camera's side sees,
// and each side's density is of the closures that it sees itself.
inline BsdfEval scatter_eval(const Scene& scene, const PathVertex& v, Vec3f wi,
                             uint8_t mask = kLobeAny) {
  if (!differs_from(v, wi)) {
    return v.bsdf.eval(wi, v.mode, mask);
  }
  Bsdf other;
  evaluate_bsdf(scene, seen_from(v.point, wi), other);
  BsdfEval e = v.bsdf.eval_forward(wi, v.mode, mask);
  if (v.mode == Transport::kRadiance) {
    e.pdf_reverse = other.eval_forward(v.point.wo, Transport::kImportance, mask).pdf;
  } else {
    const BsdfEval seen = other.eval_forward(v.point.wo, Transport::kRadiance, mask);
    e.f = seen.f * (abs_cosine(v.point, wi) / abs_cosine(v.point, v.point.wo));
    e.pdf_reverse = seen.pdf;
  }
  return e;
}

// Corrects a sample of a surface whose closures depend on the viewer.
inline bool see_from_other_side(const Scene& scene, const PathVertex& v, BsdfSample& sample) {
  if ((sample.lobe & kLobeSingular) == 0) {
    const BsdfEval e = scatter_eval(scene, v, sample.wi);
    sample.weight = e.f / sample.pdf;
    sample.pdf_reverse = e.pdf_reverse;
    return true;
  }
  Bsdf other;
  evaluate_bsdf(scene, seen_from(v.point, sample.wi), other);
  const std::optional<BsdfSample> back = other.singular_toward(v.point.wo, sample.lobe);
  sample.pdf_reverse = back ? back->pdf : 0.0f;
  const std::optional<BsdfSample> here = v.bsdf.singular_toward(sample.wi, sample.lobe);
  if (!here) {
    return false;  // by rounding
  }
  sample.pdf = here->pdf;
  if (v.mode == Transport::kRadiance) {
    sample.weight = here->weight / sample.pdf;
    return true;
  }
  if (!back) {
    return false;  // the camera's side sees no such event
  }
  // Radiance's ratio turned into importance's: the change of variables of Veach 1997, sections 5.2
  // and 5.3, of which the facet's cosines are found from the two directions.
  const Vec3f wo = v.point.wo, wi = sample.wi;
  float adjoint = 1.0f;
  if ((sample.lobe & kLobeTransparent) == 0) {
    const bool transmits = (sample.lobe & kLobeTransmission) != 0;
    const Vec3f facet = transmits && sample.eta != 1.0f ? wo + wi * sample.eta : wo + wi;
    const float along_wo = std::abs(dot(facet, wo)), along_wi = std::abs(dot(facet, wi));
    const bool straight = !(along_wi > 0.0f) || dot(wo, wi) < -kOneMinusEpsilon;
    adjoint = abs_cosine(v.point, wi) / abs_cosine(v.point, wo) *
              (straight ? 1.0f : along_wo / along_wi) / square(sample.eta);
  }
  sample.weight = back->weight * (adjoint / sample.pdf);
  return true;
}

// Samples wi at a vertex; all lobes' value and both densities. Empty: the path ends.
inline std::optional<BsdfSample> scatter_sample(const Scene& scene, const PathVertex& v,
                                                float u_lobe, Vec2f u) {
  std::optional<BsdfSample> sample = v.bsdf.sample(u_lobe, u, v.mode);
  if (sample && differs_from(v, sample->wi) && !see_from_other_side(scene, v, *sample)) {
    return std::nullopt;
  }
  return sample;
}

// The part of the merging radius within which the vertex is merged. A merge sees light that falls
// beside a point as if it fell there. Within a narrow lobe that light is elsewhere by the lobe's
// own width once the step to the side is that part of the way to what the lobe shows, and so the
// radius shrinks with the lobe. It is a matter of the surface alone: both sides agree on it.
inline float merge_scale(const PathVertex& v) {
  constexpr float kWide = 0.25f;  // alpha: a roughness of 0.5
  return std::min(v.bsdf.widest_alpha() * (1.0f / kWide), 1.0f);
}

// Tells the vertex's weights that it may be merged with others: `area` is the number of paths from
// lights times that of the disk in which they are gathered.
inline void allow_merges(const MisHeuristic& heuristic, double area, PathVertex& v) {
  if (v.other_reaches && v.bsdf.connectible()) {
    v.mis.merges(heuristic, area * square(static_cast<double>(merge_scale(v))));
  }
}

// The vertex as a sub-path leaves it along a sampled direction.
inline MisDeparture departure_of(const MisHeuristic& heuristic, const PathVertex& v,
                                 const BsdfSample& sample) {
  return {heuristic,
          v.mis,
          static_cast<double>(sample.pdf),
          static_cast<double>(sample.pdf_reverse),
          static_cast<double>(abs_cosine(v.point, sample.wi)),
          (sample.lobe & kLobeSingular) != 0,
          v.other_reaches};
}

}  // namespace vernier
