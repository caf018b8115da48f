// The walk of a light's sub-path: what all methods that start paths at lights share.
#pragma once

#include <cstdint>
#include <limits>

#include "paths/light_end.h"
#include "paths/random_walk.h"
#include "paths/subpath.h"
#include "paths/visibility.h"

namespace vernier {

// What of the light of `emission` reaches a surface `travelled` along its ray, but for what is on
// the way there. A soft lamp's light comes from before the start of the ray, by what is `behind`;
// what stands there is in its way.
inline Color lit_through(const EmissionSample& emission, const SegmentContext& segments,
                         float travelled) {
  if (!(travelled > emission.lit_from)) {
    return {};
  }
  if (!(emission.behind > 0.0f)) {
    return splat(1.0f);
  }
  bool blocked = false;
  const Ray back{emission.p, -emission.direction, emission.behind / travelled};
  const Color passed = transmittance<true>(segments, back, PathDepth{}, &blocked);
  return blocked ? Color{} : passed;
}

// Visits the surfaces that a path from a light meets, and keeps its vertices and their weights.
// What the path is for, the client says:
//   void emitted(const EmissionSample&)            the path begins;
//   void reached(const Walk&, const PathVertex&)   a vertex that may be joined to others.
template <class Client>
struct LightVisitor {
  const LightEnds& ends;
  const EmissionSample& emission;
  const SegmentContext segments;
  Walk& walk_;
  Subpath& path;
  Client& client;
  MisDeparture departure{};
  Color from_lamp = splat(1.0f);  // what of the lamp's light reaches the ray's start
  Vec3f last = {};                // where it scattered last

  bool segment(const Walk&, const Ray&, bool) { return true; }
  PathVertex& vertex() { return path.append(); }

  bool arrive(const Walk& walk, PathVertex& v) {
    if (v.traits->path_dependent) {
      path.drop();
      return false;  // what it does to light depends on the camera's part of the path
    }
    if (walk.depth.total > 0) {
      v.mis = departure.arrive(ends.heuristic, static_cast<double>(walk.travelled),
                               static_cast<double>(abs_cosine(v.point, v.point.wo)), true,
                               ends.joins_of(last, v.point.p));
    } else {
      from_lamp = lit_through(emission, segments, walk.travelled);
      if (is_black(from_lamp) && is_black(v.bsdf.transparency)) {
        path.drop();
        return false;
      }
      v.beta *= from_lamp;
      v.mis = first_from_light(ends, emission, v, walk.travelled);
    }
    if (ends.merge_area > 0.0) {
      allow_merges(ends.heuristic, ends.merge_area, v);
    }
    if (v.bsdf.connectible() && !is_black(v.beta)) {
      client.reached(walk, v);
    }
    return true;
  }

  void pass(const PathVertex& v) {
    if (!v.bsdf.connectible()) {
      path.drop();
    }
  }
  void leave(const PathVertex& v, const BsdfSample& sample) {
    path.scatter();
    if (v.parent == kNoIndex) {
      walk_.beta *= from_lamp;
    }
    departure = departure_of(ends.heuristic, v, sample);
    last = v.point.p;
  }
};

// How a path from a light starts, by the sampler's numbers. False: there is none.
template <class Sampler>
bool emit(const LightSampler& lights, const EmissionGuide& guide, const Sampler& sampler,
          EmissionSample& out) {
  return lights.sample_emission(guide, sampler.get_2d(dimension(LightDim::kChoice)).x,
                                sampler.get_2d(dimension(LightDim::kPosition)),
                                sampler.get_2d(dimension(LightDim::kDirection)), out);
}

// The start of a walk along that path. False where there is none to follow; `non_finite` counts
// those whose radiance is not finite.
template <class Sampler>
bool start_at_light(const Scene& scene, const EmissionGuide& guide, const Sampler& sampler,
                    EmissionSample& e, Walk& walk, uint64_t& non_finite) {
  if (!emit(*scene.lights, guide, sampler, e)) {
    return false;
  }
  walk.ray = {e.infinite ? e.p : offset_origin(e.p, e.p_error, e.n, e.direction), e.direction,
              kInfinity};
  walk.mode = Transport::kImportance;
  walk.beta = e.radiance * (e.cosine / (e.pdf_position * e.pdf_direction * e.pdf_selection));
  if (!is_finite(walk.beta)) {
    ++non_finite;
    return false;
  }
  walk.start = max_component(walk.beta);
  walk.flags = 0;
  walk.mask = kVisibleDiffuse;  // evenly visible scenes: all kinds of scattered rays are alike
  return true;
}

// Starts a path at a light and follows it. `path`, empty before, gets its vertices. `non_finite`
// counts the paths that were dropped because what they carry is not finite. It bounces no more than
// `most_bounces` times.
template <class Sampler, class Client>
void walk_from_light(const LightEnds& ends, const WalkContext<Sampler>& context, Subpath& path,
                     uint64_t& non_finite, Client& client,
                     int most_bounces = std::numeric_limits<int>::max()) {
  EmissionSample e;
  Walk walk;
  if (!start_at_light(ends.scene, ends.guide, context.sampler, e, walk, non_finite)) {
    return;
  }
  walk.most_bounces = most_bounces;
  client.emitted(e);
  LightVisitor<Client> visitor{ends, e,    {ends.scene, context.limits.transparent, context.rays},
                               walk, path, client};
  random_walk(context, walk, visitor);
}

}  // namespace vernier
