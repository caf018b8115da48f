// How paths that start at lights are shared out.
#pragma once

#include "math/distribution.h"
#include "math/vec.h"

namespace vernier {

// Any guide gives the same picture; a good one starts paths where they matter.
struct EmissionGuide {
  AliasTable lights;  // which light a path starts at
  // A part `share` in [0, 1) of the rays of suns and the environment passes this sphere, uniformly
  // over its disk; the rest passes the sphere of the whole scene. Render space.
  Vec3f center;
  float radius = 0;
  float share = 0;
};

}  // namespace vernier
