// Limits on single kinds of bounces, for paths that lights have a part in.
//
// A walk from the camera knows of which kind a bounce is by the lobe that it sampled. Given both
// directions at a vertex, that was a diffuse lobe or a glossy one by their shares in the density
// from the camera's side. So a path is within the limits by chance: every technique may draw kinds
// by these shares or weigh the path by what they come to, whichever end its vertices were made
// from. Densities of paths are not touched. The last surface before the light does not count: it is
// the first of a walk from the light.
#pragma once

#include <array>

#include "paths/bounce_limits.h"
#include "paths/path_vertex.h"

namespace vernier {

// The chances that a bounce is diffuse, glossy, a transmission, or does not count; their sum is 1.
using KindChances = std::array<float, 4>;
inline constexpr KindChances kNotCounted{0.0f, 0.0f, 0.0f, 1.0f};

// Of a vertex where light scatters between v.point.wo and wi by smooth lobes.
inline KindChances kind_chances(const Scene& scene, const PathVertex& v, Vec3f wi) {
  if (dot(v.point.ng, wi) < 0.0f) {
    return {0.0f, 0.0f, 1.0f, 0.0f};
  }
  float diffuse;
  if (v.mode == Transport::kRadiance || !differs_from(v, wi)) {
    diffuse = v.bsdf.diffuse_share(wi, v.mode);
  } else {
    Bsdf camera_side;
    evaluate_bsdf(scene, seen_from(v.point, wi), camera_side);
    diffuse = camera_side.diffuse_share(v.point.wo, Transport::kRadiance);
  }
  return {diffuse, 1.0f - diffuse, 0.0f, 0.0f};
}

// The same of the last vertex of a walk from a light.
inline KindChances kind_chances_from_light(const Scene& scene, const PathVertex& v, Vec3f wi) {
  return v.point.depth.total == 0 ? kNotCounted : kind_chances(scene, v, wi);
}

// The chance that a path is within the limits on kinds, of which one part has bounced as `camera`
// says, another as `light` does, and which bounces twice besides.
inline float chance_within(const BounceLimits& limits, const PathDepth& camera,
                           const PathDepth& light, const KindChances& a, const KindChances& b) {
  const std::array<int, 3> left{limits.diffuse - camera.diffuse - light.diffuse,
                                limits.glossy - camera.glossy - light.glossy,
                                limits.transmission - camera.transmission - light.transmission};
  if (left[0] < 0 || left[1] < 0 || left[2] < 0) {
    return 0.0f;
  }
  const auto allowed = [&](size_t kind, int times) { return kind == 3 || left[kind] >= times; };
  float chance = 0.0f;
  for (size_t i = 0; i < a.size(); ++i) {
    for (size_t j = 0; j < b.size(); ++j) {
      if (allowed(i, 1) && allowed(j, i == j ? 2 : 1)) {
        chance += a[i] * b[j];
      }
    }
  }
  return chance;
}

// scatter() for a walk from a light whose bounces count by kind: u in [0,1) draws the kind that the
// camera's side sees.
inline void scatter_from_light(const Scene& scene, const PathVertex& v, const BsdfSample& sample,
                               float u, PathDepth& depth, uint32_t& ray_flags, uint32_t& ray_mask) {
  const PathDepth before = depth;
  uint8_t lobe = sample.lobe;
  const bool first = before.total == 0;
  if (!first && (lobe & kLobeSingular) == 0 && (lobe & kLobeTransmission) == 0) {
    lobe = static_cast<uint8_t>(
        kLobeReflection | (u < kind_chances(scene, v, sample.wi)[0] ? kLobeDiffuse : kLobeGlossy));
  }
  scatter(lobe, depth, ray_flags, ray_mask);
  if (first) {
    depth.diffuse = before.diffuse;
    depth.glossy = before.glossy;
    depth.transmission = before.transmission;
  }
}

}  // namespace vernier
