// The end of a light's sub-path, as far as it takes to see whether a join is worth its work.
#pragma once

#include <cstdint>

#include "paths/path_vertex.h"

namespace vernier {

// 44 bytes, where a vertex has thousands: most joins end here.
struct JoinEnd {
  Vec3f p, ng;       // PathVertex::point
  Color brightness;  // throughput times the order of magnitude of the BSDF
  uint32_t number;   // of the vertex in its sub-path
  uint16_t bounces;  // before it

  JoinEnd() = default;
  JoinEnd(const PathVertex& v, uint32_t number_)
      : p(v.point.p),
        ng(v.point.ng),
        brightness(v.beta * vernier::brightness(v)),
        number(number_),
        bounces(v.point.depth.total) {}
};

}  // namespace vernier
