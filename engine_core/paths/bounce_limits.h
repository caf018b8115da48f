// Which rays a scattering event makes, and when limits end a path.
#pragma once

#include <cstdint>
#include <limits>

#include "bsdf/bsdf.h"
#include "render/settings.h"
#include "scene/surface_point.h"

namespace vernier {

// Limits on the bounces of a path, in Blender's kinds. No limit is the largest integer.
struct BounceLimits {
  int total, diffuse, glossy, transmission, transparent;

  explicit BounceLimits(const Settings& s)
      : total(limit(s.max_bounces)),
        diffuse(limit(s.diffuse_bounces)),
        glossy(limit(s.glossy_bounces)),
        transmission(limit(s.transmission_bounces)),
        transparent(limit(s.transparent_bounces)) {}

  // Whether a path that has bounced `depth` times may exist.
  bool allow(const PathDepth& depth) const {
    return depth.total <= total && depth.diffuse <= diffuse && depth.glossy <= glossy &&
           depth.transmission <= transmission && depth.transparent <= transparent;
  }

  // Whether a path may exist that joins one from the camera and one from a light which have
  // bounced so often before the vertices that are joined.
  bool allow_joined(const PathDepth& camera, const PathDepth& light) const {
    return camera.total + light.total + 1 < total && camera.diffuse + light.diffuse <= diffuse &&
           camera.glossy + light.glossy <= glossy &&
           camera.transmission + light.transmission <= transmission;
  }

 private:
  static int limit(int setting) { return setting < 0 ? std::numeric_limits<int>::max() : setting; }
};

// A counter that stays at its largest value.
inline void count(uint16_t& counter) {
  counter = static_cast<uint16_t>(counter + (counter < 0xffffu ? 1u : 0u));
}

// Advances what the next vertex will read of the path. Transparency keeps the kind of the ray, as
// light passes as if nothing were there; a transmission counts as that alone (Cycles,
// path_state_next and path_state_ray_visibility).
inline void scatter(uint8_t lobe, PathDepth& depth, uint32_t& ray_flags, uint32_t& ray_mask) {
  if ((lobe & kLobeTransparent) != 0) {
    count(depth.transparent);
    return;
  }
  count(depth.total);
  ray_flags = 0;
  if ((lobe & kLobeTransmission) != 0) {
    count(depth.transmission);
    ray_flags |= kRayTransmission;
    ray_mask = kVisibleTransmission;
  } else {
    ray_flags |= kRayReflection;
    if ((lobe & kLobeDiffuse) != 0) {
      count(depth.diffuse);
      ray_mask = kVisibleDiffuse;
    } else {
      count(depth.glossy);
      ray_mask = kVisibleGlossy;
    }
  }
  if ((lobe & kLobeDiffuse) != 0) {
    ray_flags |= kRayDiffuse;
  } else {
    ray_flags |= kRayGlossy | ((lobe & kLobeSingular) != 0 ? kRaySingular : 0u);
  }
}

// The lobes that a light with these Visibility bits lights.
inline uint8_t lobes_lit(uint32_t visibility) {
  uint8_t mask = kLobeAny;
  if ((visibility & kVisibleDiffuse) == 0) {
    mask = static_cast<uint8_t>(mask & ~kLobeDiffuse);
  }
  if ((visibility & kVisibleGlossy) == 0) {
    mask = static_cast<uint8_t>(mask & ~kLobeGlossy);
  }
  if ((visibility & kVisibleTransmission) == 0) {
    mask = static_cast<uint8_t>(mask & ~kLobeTransmission);
  }
  return mask;
}

}  // namespace vernier
