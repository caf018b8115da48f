#include "textures/voronoi.h"

#include "textures/hash.h"

namespace vernier {
namespace {

template <int N>
using Point = std::array<float, N>;
template <int N>
using Cell = std::array<int32_t, N>;

constexpr float kFar = std::numeric_limits<float>::max();

// The PCG hashes of Jarzynski and Olano 2020 on signed words, whose shift keeps the sign, as in
// Cycles; results in [0, 1].
int32_t multiply_add(int32_t a, int32_t b, int32_t c) {
  return static_cast<int32_t>(static_cast<uint32_t>(a) * static_cast<uint32_t>(b) +
                              static_cast<uint32_t>(c));
}

template <int N>
void mix_words(Cell<N>& v) {
  if constexpr (N == 2) {
    v[0] = multiply_add(v[1], 1664525, v[0]);
    v[1] = multiply_add(v[0], 1664525, v[1]);
  } else if constexpr (N == 3) {
    v[0] = multiply_add(v[1], v[2], v[0]);
    v[1] = multiply_add(v[2], v[0], v[1]);
    v[2] = multiply_add(v[0], v[1], v[2]);
  } else {
    v[0] = multiply_add(v[1], v[3], v[0]);
    v[1] = multiply_add(v[2], v[0], v[1]);
    v[2] = multiply_add(v[0], v[1], v[2]);
    v[3] = multiply_add(v[1], v[2], v[3]);
  }
}

template <int N>
Point<N> hash_cell(Cell<N> v) {
  for (int32_t& x : v) {
    x = multiply_add(x, 1664525, 1013904223);
  }
  mix_words<N>(v);
  for (int32_t& x : v) {
    x ^= x >> 16;
  }
  mix_words<N>(v);
  Point<N> f;
  for (size_t d = 0; d < N; ++d) {
    f[d] = static_cast<float>(v[d] & 0x7fffffff) * (1.0f / 2147483647.0f);
  }
  return f;
}

// One dimension hashes the bits of the cell's number as a float.
template <>
Point<1> hash_cell<1>(Cell<1> v) {
  return {hash_floats(static_cast<float>(v[0]))};
}

template <int N>
Color cell_color(const Cell<N>& cell) {
  if constexpr (N == 1) {
    const auto k = static_cast<float>(cell[0]);
    return {hash_floats(k), hash_floats(k, 1.0f), hash_floats(k, 2.0f)};
  } else if constexpr (N == 2) {
    const Point<3> h = hash_cell<3>({cell[0], cell[1], 0});
    return {h[0], h[1], h[2]};
  } else {
    const Point<N> h = hash_cell<N>(cell);
    return {h[0], h[1], h[2]};
  }
}

template <int N>
float squared_length(const Point<N>& a) {
  float sum = 0.0f;
  for (const float x : a) {
    sum += x * x;
  }
  return sum;
}

template <int N>
Point<N> minus(const Point<N>& a, const Point<N>& b) {
  Point<N> r;
  for (size_t d = 0; d < N; ++d) {
    r[d] = a[d] - b[d];
  }
  return r;
}

template <int N>
float distance(const Point<N>& a, const Point<N>& b, const VoronoiParams& params) {
  float sum = 0.0f, largest = 0.0f;
  if (N == 1) {
    return std::abs(a[0] - b[0]);
  }
  switch (params.metric) {
    case VoronoiMetric::kEuclidean:
      return std::sqrt(squared_length<N>(minus<N>(a, b)));
    case VoronoiMetric::kManhattan:
      for (size_t d = 0; d < N; ++d) {
        sum += std::abs(a[d] - b[d]);
      }
      return sum;
    case VoronoiMetric::kChebychev:
      for (size_t d = 0; d < N; ++d) {
        largest = std::max(largest, std::abs(a[d] - b[d]));
      }
      return largest;
    case VoronoiMetric::kMinkowski:
      for (size_t d = 0; d < N; ++d) {
        sum += std::pow(std::abs(a[d] - b[d]), params.exponent);
      }
      return std::pow(sum, 1.0f / params.exponent);
  }
  return 0.0f;
}

// A coordinate taken apart: its cell, and where in the cell it is.
template <int N>
struct Location {
  Cell<N> cell;
  Point<N> local;

  explicit Location(const Point<N>& p) {
    for (size_t d = 0; d < N; ++d) {
      const float x = std::isfinite(p[d]) ? p[d] : 0.0f;
      const float floor = std::floor(x);
      cell[d] = static_cast<int32_t>(clamp(floor, -2147483520.0f, 2147483520.0f));
      local[d] = x - floor;
    }
  }
  Cell<N> neighbour(const Cell<N>& offset) const {
    Cell<N> c;
    for (size_t d = 0; d < N; ++d) {
      c[d] = multiply_add(offset[d], 1, cell[d]);
    }
    return c;
  }
  // The jittered point of a neighbour, relative to this cell.
  Point<N> point(const Cell<N>& offset, const VoronoiParams& params) const {
    Point<N> p = hash_cell<N>(neighbour(offset));
    for (size_t d = 0; d < N; ++d) {
      p[d] = static_cast<float>(offset[d]) + p[d] * params.randomness;
    }
    return p;
  }
};

// Visits the cells within `reach`, the first dimension fastest.
template <int N, typename Visit>
void for_each_neighbour(int reach, Visit visit) {
  Cell<N> offset;
  offset.fill(-reach);
  while (true) {
    visit(offset);
    size_t d = 0;
    while (d < N && offset[d] == reach) {
      offset[d++] = -reach;
    }
    if (d == N) {
      return;
    }
    ++offset[d];
  }
}

template <int N>
Vec4f as_position(const Location<N>& at, const Point<N>& p) {
  Vec4f r;
  if constexpr (N == 1) {
    r.w = static_cast<float>(at.cell[0]) + p[0];
  } else {
    r.x = static_cast<float>(at.cell[0]) + p[0];
    r.y = static_cast<float>(at.cell[1]) + p[1];
    if constexpr (N > 2) {
      r.z = static_cast<float>(at.cell[2]) + p[2];
    }
    if constexpr (N > 3) {
      r.w = static_cast<float>(at.cell[3]) + p[3];
    }
  }
  return r;
}

// The nearest point, or with `second` the next one.
template <int N>
VoronoiCell nearest(const Point<N>& p, const VoronoiParams& params, bool second) {
  const Location<N> at(p);
  struct Found {
    float distance = kFar;
    Cell<N> offset{};
    Point<N> point{};
  } first, next;
  for_each_neighbour<N>(1, [&](const Cell<N>& offset) {
    const Point<N> q = at.point(offset, params);
    const float d = distance<N>(q, at.local, params);
    if (d < first.distance) {
      next = first;
      first = {d, offset, q};
    } else if (d < next.distance) {
      next = {d, offset, q};
    }
  });
  const Found& found = second ? next : first;
  return {found.distance, cell_color<N>(at.neighbour(found.offset)),
          as_position<N>(at, found.point)};
}

// Distances blended by a smooth minimum, and colours and positions with them.
template <int N>
VoronoiCell smooth_nearest(const Point<N>& p, const VoronoiParams& params) {
  const Location<N> at(p);
  float smooth = 0.0f;
  Color color;
  Point<N> position{};
  bool is_first = true;
  for_each_neighbour<N>(2, [&](const Cell<N>& offset) {
    const Point<N> q = at.point(offset, params);
    const float d = distance<N>(q, at.local, params);
    float h = 1.0f;
    if (!is_first) {
      const float t = saturate(0.5f + 0.5f * (smooth - d) / params.smoothness);
      h = t * t * (3.0f - 2.0f * t);
    }
    is_first = false;
    float correction = params.smoothness * h * (1.0f - h);
    smooth = smooth + h * (d - smooth) - correction;
    correction /= 1.0f + 3.0f * params.smoothness;
    const Color c = cell_color<N>(at.neighbour(offset));
    color = color + (c - color) * h - splat(correction);
    for (size_t k = 0; k < N; ++k) {
      position[k] = position[k] + h * (q[k] - position[k]) - correction;
    }
  });
  return {smooth, color, as_position<N>(at, position)};
}

// Euclidean distance to the border of the nearest point's cell.
template <int N>
float distance_to_edge(const Point<N>& p, const VoronoiParams& params) {
  const Location<N> at(p);
  if constexpr (N == 1) {
    const float middle = at.point({0}, params)[0];
    const float left = std::abs((middle + at.point({-1}, params)[0]) / 2.0f - at.local[0]);
    const float right = std::abs((middle + at.point({1}, params)[0]) / 2.0f - at.local[0]);
    return std::min(left, right);
  } else {
    Point<N> closest{};
    float least = kFar;
    for_each_neighbour<N>(1, [&](const Cell<N>& offset) {
      const Point<N> v = minus<N>(at.point(offset, params), at.local);
      const float d = squared_length<N>(v);
      if (d < least) {
        least = d;
        closest = v;
      }
    });
    constexpr float kSamePoint = 0.0001f;  // squared distance below which Cycles sees one point
    float edge = kFar;
    for_each_neighbour<N>(1, [&](const Cell<N>& offset) {
      const Point<N> v = minus<N>(at.point(offset, params), at.local);
      const Point<N> across = minus<N>(v, closest);
      const float squared = squared_length<N>(across);
      if (squared > kSamePoint) {
        float along = 0.0f;
        for (size_t d = 0; d < N; ++d) {
          along += (closest[d] + v[d]) * 0.5f * across[d];
        }
        edge = std::min(edge, along / std::sqrt(squared));
      }
    });
    return edge;
  }
}

// Radius of the sphere about the nearest point that reaches half way to its own nearest one.
template <int N>
float sphere_radius(const Point<N>& p, const VoronoiParams& params) {
  const Location<N> at(p);
  Point<N> closest{};
  Cell<N> closest_offset{};
  float least = kFar;
  for_each_neighbour<N>(1, [&](const Cell<N>& offset) {
    const Point<N> q = at.point(offset, params);
    const float d = squared_length<N>(minus<N>(q, at.local));
    if (d < least) {
      least = d;
      closest = q;
      closest_offset = offset;
    }
  });
  least = kFar;
  for_each_neighbour<N>(1, [&](const Cell<N>& offset) {
    if (offset == Cell<N>{}) {
      return;
    }
    Cell<N> around = offset;
    for (size_t d = 0; d < N; ++d) {
      around[d] += closest_offset[d];
    }
    least = std::min(least, squared_length<N>(minus<N>(closest, at.point(around, params))));
  });
  return std::sqrt(least) / 2.0f;
}

template <int N>
Point<N> scaled(Point<N> p, float s) {
  for (float& x : p) {
    x *= s;
  }
  return p;
}

Vec4f mix(Vec4f a, Vec4f b, float t) { return a * (1.0f - t) + b * t; }

template <int N>
VoronoiCell octave_of(const Point<N>& p, const VoronoiParams& params) {
  if (params.feature == VoronoiFeature::kSmoothF1 && params.smoothness != 0.0f) {
    return smooth_nearest<N>(p, params);
  }
  return nearest<N>(p, params, params.feature == VoronoiFeature::kF2);
}

template <int N>
VoronoiCell fractal(const Point<N>& p, const VoronoiParams& params) {
  VoronoiCell sum;
  float total = 0.0f, amplitude = 1.0f, scale = 1.0f;
  if (params.detail == 0.0f || params.roughness == 0.0f) {
    sum = octave_of<N>(p, params);
    total = 1.0f;
  } else {
    const auto octaves = static_cast<int>(std::floor(params.detail));
    for (int i = 0; i <= octaves; ++i) {
      const VoronoiCell o = octave_of<N>(scaled<N>(p, scale), params);
      total += amplitude;
      sum.distance += o.distance * amplitude;
      sum.color += o.color * amplitude;
      sum.position = mix(sum.position, o.position * (1.0f / scale), amplitude);
      scale *= params.lacunarity;
      amplitude *= params.roughness;
    }
    const float fraction = params.detail - static_cast<float>(octaves);
    if (fraction != 0.0f) {
      const VoronoiCell o = octave_of<N>(scaled<N>(p, scale), params);
      total += fraction * amplitude;
      sum.distance += fraction * o.distance * amplitude;
      sum.color += o.color * (fraction * amplitude);
      sum.position =
          mix(sum.position, mix(sum.position, o.position * (1.0f / scale), amplitude), fraction);
    }
  }
  if (params.normalize) {
    Point<N> corner;
    corner.fill(0.5f + 0.5f * params.randomness);
    const float farthest = distance<N>(Point<N>{}, corner, params) *
                           (params.feature == VoronoiFeature::kF2 ? 2.0f : 1.0f);
    sum.distance /= total * farthest;
    sum.color *= 1.0f / total;
  }
  const float s = params.scale != 0.0f ? 1.0f / params.scale : 0.0f;
  sum.position = sum.position * s;
  return sum;
}

template <int N>
float fractal_edge(const Point<N>& p, const VoronoiParams& params) {
  constexpr float kStart = 8.0f;  // Cycles' distance before the first octave
  const float farthest = 0.5f + 0.5f * params.randomness;
  if (params.detail == 0.0f || params.roughness == 0.0f) {
    const float edge = distance_to_edge<N>(p, params);
    return params.normalize ? edge / farthest : edge;
  }
  float edge = kStart, largest = farthest, amplitude = 1.0f, scale = 1.0f;
  const auto octaves = static_cast<int>(std::floor(params.detail));
  const auto blended = [](float a, float b, float t) { return a + t * (b - a); };
  for (int i = 0; i <= octaves; ++i) {
    const float o = distance_to_edge<N>(scaled<N>(p, scale), params) / scale;
    largest = blended(largest, farthest / scale, amplitude);
    edge = blended(edge, std::min(edge, o), amplitude);
    scale *= params.lacunarity;
    amplitude *= params.roughness;
  }
  const float fraction = params.detail - static_cast<float>(octaves);
  if (fraction != 0.0f) {
    const float o = distance_to_edge<N>(scaled<N>(p, scale), params) / scale;
    largest = blended(largest, blended(largest, farthest / scale, amplitude), fraction);
    edge = blended(edge, std::min(edge, blended(edge, std::min(edge, o), amplitude)), fraction);
  }
  return params.normalize ? edge / largest : edge;
}

template <int N>
VoronoiCell evaluate(const Point<N>& p, const VoronoiParams& params) {
  VoronoiCell result;
  if (params.feature == VoronoiFeature::kDistanceToEdge) {
    result.distance = fractal_edge<N>(p, params);
  } else if (params.feature == VoronoiFeature::kNSphereRadius) {
    result.distance = sphere_radius<N>(p, params);
  } else {
    result = fractal<N>(p, params);
  }
  return result;
}

}  // namespace

VoronoiCell voronoi_texture(int dimensions, Vec4f p, const VoronoiParams& params) {
  switch (dimensions) {
    case 1:
      return evaluate<1>({p.w}, params);
    case 2:
      return evaluate<2>({p.x, p.y}, params);
    case 3:
      return evaluate<3>({p.x, p.y, p.z}, params);
    default:
      return evaluate<4>({p.x, p.y, p.z, p.w}, params);
  }
}

}  // namespace vernier
