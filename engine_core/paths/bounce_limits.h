// Which rays a scattering event makes, and when limits end a path.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include "bsdf/bsdf.h"
#include "render/settings.h"
#include "scene/description.h"
#include "scene/surface_point.h"

namespace vernier {

// Limits on the bounces of a path, as Cycles has them: the last surface before the light does not
// count, so that a limit of 0 leaves direct light. No limit is the largest integer.
struct BounceLimits {
  int total;  // one more than the setting: all surfaces at which a path scatters
  int diffuse, glossy, transmission, transparent;
  bool kinds_from_lights = false;  // walks from lights count bounces by kind: see bounce_kinds.h

  explicit BounceLimits(const Settings& s)
      : total(limit(s.max_bounces)),
        diffuse(limit(s.diffuse_bounces)),
        glossy(limit(s.glossy_bounces)),
        transmission(limit(s.transmission_bounces)),
        transparent(limit(s.transparent_bounces)) {
    total += total < kNone ? 1 : 0;
    // A counter that stays at its largest value must be beyond every limit.
    for (int* most : {&total, &transparent}) {
      *most = *most < kNone ? std::min(*most, kMostCounted - 1) : kNone;
    }
  }

  // Whether a path that has bounced `depth` times may exist.
  bool allow(const PathDepth& depth) const {
    return depth.total <= total && depth.transparent <= transparent;
  }
  // Whether it has bounced too often in one way to do more than meet a light.
  bool spent(const PathDepth& depth) const {
    return depth.diffuse > diffuse || depth.glossy > glossy || depth.transmission > transmission;
  }
  // Whether a path may exist that joins one from the camera and one from a light which have
  // bounced so often before the vertices that are joined.
  bool allow_joined(int camera, int light) const { return camera + light + 1 < total; }

  // For methods that join paths from lights to the camera's.
  static BounceLimits of_both_sides(const Settings& s) {
    BounceLimits limits(s);
    limits.kinds_from_lights = by_kind(s);
    return limits;
  }

  // Whether there are limits on single kinds of bounces.
  static bool by_kind(const Settings& s) {
    return s.diffuse_bounces >= 0 || s.glossy_bounces >= 0 || s.transmission_bounces >= 0;
  }

 private:
  static constexpr int kNone = std::numeric_limits<int>::max();
  static constexpr int kMostCounted = std::numeric_limits<decltype(PathDepth::total)>::max();
  static int limit(int setting) { return setting < 0 ? kNone : setting; }
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
