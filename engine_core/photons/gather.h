// Radiance from photons: density estimation on surfaces.
//
// What a surface scatters is estimated from the photons near the point, as if they had met it at
// the point itself (Jensen 2001, section 7): sum of f Phi K(d) over those within radius r, where
// the kernel K is a density over the disk. The classic artefacts, and what limits them:
// - Light through thin walls: photons on a wall's far side came from there, and the surface's
//   reflection of what comes from below it is zero; where it transmits, photons must lie in a disk,
//   not in a ball: within r times kThickness of the tangent plane (disc compression).
// - Light around corners: photons on surfaces whose normals differ by more than 60 degrees do not
//   count.
// - Dark rims where a surface ends within r, and blur of edges, vanish with the radius only: by its
//   bound in pixels, and by shrinking it.
// - Shading normals: a photon is flux through the geometric surface, so that f |cos ns| goes over
//   |cos ng|.
#pragma once

#include <cstdint>

#include "paths/path_vertex.h"
#include "photons/photon_map.h"

namespace vernier {

enum class PhotonKernel : int { kEpanechnikov, kCone, kConstant };

// Cosine of the largest angle between the surfaces of the point and of a photon.
inline constexpr float kLeastAlignment = 0.5f;
// Half the height of the gathered disk over its radius. A sphere keeps all photons within half its
// own radius.
inline constexpr float kThickness = 0.25f;

// The kernel at squared distance d2 of radius^2 r2, times r2: over the disk it integrates to r2.
inline float photon_kernel(PhotonKernel kernel, float d2, float r2) {
  const float t = d2 / r2;
  switch (kernel) {
    case PhotonKernel::kEpanechnikov:
      return 2.0f * kInvPi * (1.0f - t);
    case PhotonKernel::kCone:
      return 3.0f * kInvPi * (1.0f - std::sqrt(t));  // Jensen 2001, section 7.2.1, with k = 1
    case PhotonKernel::kConstant:
      return kInvPi;
  }
  return 0.0f;
}

// The part of a path's light that comes after its last photon: which photons a vertex may gather.
struct Gathering {
  const PathVertex& v;
  uint8_t lobes;     // that gather
  int bounces_left;  // most bounces of photons; from Photon::kMostBounces on: no limit
  PhotonKernel kernel;

  // Whether what the photon's surface is like, and where it is, makes it count for the point.
  bool fits(Vec3f position, const Photon& photon, float radius) const {
    const Vec3f ng = v.point.ng;
    return std::abs(dot(photon.ng(), ng)) >= kLeastAlignment &&
           std::abs(dot(position - v.point.p, ng)) <= kThickness * radius &&
           (photon.bounces <= bounces_left || bounces_left >= Photon::kMostBounces);
  }

  // What the photon adds, before the kernel.
  Color scattered(const Photon& photon, Vec3f wi) const {
    const BsdfEval eval = v.bsdf.eval_forward(wi, Transport::kRadiance, lobes);
    const float there = std::abs(dot(photon.ng(), wi)) - Photon::kNormalRounding;
    return eval.f * photon.power * (1.0f / flux_cosine(v.point, wi, there));
  }
};

// Calls each(wi, radiance, direct) for what every photon of the map within `radius` adds.
template <class Each>
void gather_within(const PhotonMap& map, const Gathering& g, float radius, const Each& each) {
  const float r2 = square(radius);
  map.tree().for_each(g.v.point.p, r2, [&](uint32_t place, float d2) {
    const Photon& photon = map.photon(place);
    if (g.fits(map.tree().position(place), photon, radius)) {
      const Vec3f wi = photon.wi();
      const float weight = photon_kernel(g.kernel, d2, r2) * map.scale() / r2;
      each(wi, g.scattered(photon, wi) * weight, photon.kind == PhotonKind::kDirect);
    }
  });
}

// The same for the nearest photons, as many as `found` has room for and at most `radius` away.
// Where there are enough, the distance of the farthest is the radius, and it does not count itself:
// on an evenly lit plane the estimate is then unbiased for every kernel and number (the farthest is
// where the area was stopped; the rest is spread evenly within).
template <class Each>
void gather_nearest(const PhotonMap& map, const Gathering& g, float radius,
                    std::span<KdNeighbour> found, const Each& each) {
  const size_t count = map.tree().nearest(g.v.point.p, found.size(), square(radius), found);
  const bool full = count == found.size();
  // Photons that all lie in one point leave no area but what float32 tells apart.
  const float least = max_component(g.v.point.p_error);
  const float r2 = full ? std::max(found.front().distance_squared, square(least)) : square(radius);
  const float r = std::sqrt(r2);
  for (size_t i = full ? 1 : 0; i < count; ++i) {
    const Photon& photon = map.photon(found[i].place);
    if (g.fits(map.tree().position(found[i].place), photon, r)) {
      const Vec3f wi = photon.wi();
      const float weight =
          photon_kernel(g.kernel, found[i].distance_squared, r2) * map.scale() / r2;
      each(wi, g.scattered(photon, wi) * weight, photon.kind == PhotonKind::kDirect);
    }
  }
}

}  // namespace vernier
