#include "scene/triangulate.h"

#include <numeric>

namespace vernier {
namespace {

// Twice the signed area of the triangle (a, b, c) in the plane.
float orientation(Vec2f a, Vec2f b, Vec2f c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

bool contains(Vec2f a, Vec2f b, Vec2f c, Vec2f p) {
  return orientation(a, b, p) >= 0.0f && orientation(b, c, p) >= 0.0f &&
         orientation(c, a, p) >= 0.0f;
}

// The polygon's area vector (Newell's method): its direction is the mean normal.
Vec3f area_vector(std::span<const Vec3f> p) {
  Vec3f n;
  for (size_t i = 0; i < p.size(); ++i) {
    n += cross(p[i] - p[0], p[(i + 1) % p.size()] - p[0]);
  }
  return n;
}

// A quadrilateral is cut from corner 0 to 2, as Blender does, unless that cut lies outside it.
bool cut_from_first(std::span<const Vec3f> p) {
  const Vec3f n = area_vector(p);
  const float a = dot(cross(p[1] - p[0], p[2] - p[0]), n);
  const float b = dot(cross(p[2] - p[0], p[3] - p[0]), n);
  return a >= 0.0f && b >= 0.0f;
}

void cut_ears(std::span<const Vec3f> polygon, std::vector<std::array<uint32_t, 3>>& triangles) {
  // Project along the largest component of the normal, keeping the orientation positive.
  const Vec3f n = area_vector(polygon);
  const Vec3f m = abs(n);
  const int drop = m.x > m.y ? (m.x > m.z ? 0 : 2) : (m.y > m.z ? 1 : 2);
  const int first = (drop + 1) % 3, second = (drop + 2) % 3;
  const float sign = n[drop] < 0.0f ? -1.0f : 1.0f;
  std::vector<Vec2f> q(polygon.size());
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Vec3f d = polygon[i] - polygon[0];
    q[i] = {d[first], sign * d[second]};
  }
  std::vector<uint32_t> left(polygon.size());
  std::iota(left.begin(), left.end(), 0u);
  size_t at = 0;
  size_t refused = 0;  // corners looked at since the last ear
  while (left.size() > 3) {
    const size_t count = left.size();
    const size_t before = (at + count - 1) % count, after = (at + 1) % count;
    const Vec2f a = q[left[before]], b = q[left[at]], c = q[left[after]];
    bool ear = orientation(a, b, c) > 0.0f;
    for (size_t k = 0; ear && k < count; ++k) {
      if (k != before && k != at && k != after) {
        ear = !contains(a, b, c, q[left[k]]);
      }
    }
    // A polygon that crosses itself may have no ear: then any corner is cut, so that the loop ends.
    if (ear || refused >= count) {
      triangles.push_back({left[before], left[at], left[after]});
      left.erase(left.begin() + static_cast<ptrdiff_t>(at));
      at = before < at ? before : left.size() - 1;
      refused = 0;
    } else {
      at = after;
      ++refused;
    }
  }
  triangles.push_back({left[0], left[1], left[2]});
}

}  // namespace

void triangulate(std::span<const Vec3f> polygon, std::vector<std::array<uint32_t, 3>>& triangles) {
  if (polygon.size() == 3) {
    triangles.push_back({0, 1, 2});
  } else if (polygon.size() == 4) {
    if (cut_from_first(polygon)) {
      triangles.push_back({0, 1, 2});
      triangles.push_back({0, 2, 3});
    } else {
      triangles.push_back({0, 1, 3});
      triangles.push_back({1, 2, 3});
    }
  } else if (polygon.size() > 4) {
    cut_ears(polygon, triangles);
  }
}

}  // namespace vernier
