#include "scene/triangulate.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

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

// The polygon in the plane of its area vector's largest component, counterclockwise.
std::vector<Vec2f> project(std::span<const Vec3f> polygon) {
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
  return q;
}

// Corners by the cells of a regular grid over their box.
class CornerGrid {
 public:
  CornerGrid(std::span<const Vec2f> points, std::span<const uint32_t> corners) : points_(points) {
    // Some two corners a cell.
    side_ = std::max(1, static_cast<int>(std::sqrt(static_cast<double>(corners.size()) / 2.0)));
    Vec2f upper{-kInfinity, -kInfinity};
    lower_ = {kInfinity, kInfinity};
    for (const uint32_t c : corners) {
      lower_ = {std::min(lower_.x, points[c].x), std::min(lower_.y, points[c].y)};
      upper = {std::max(upper.x, points[c].x), std::max(upper.y, points[c].y)};
    }
    const auto side = static_cast<float>(side_);
    scale_ = {side / (upper.x - lower_.x), side / (upper.y - lower_.y)};
    // Counting sort.
    first_.assign(static_cast<size_t>(side_) * static_cast<size_t>(side_) + 1, 0);
    for (const uint32_t c : corners) {
      ++first_[cell(column(points[c].x), row(points[c].y)) + 1];
    }
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    sorted_.resize(corners.size());
    std::vector<uint32_t> next(first_.begin(), first_.end() - 1);
    for (const uint32_t c : corners) {
      sorted_[next[cell(column(points[c].x), row(points[c].y))]++] = c;
    }
  }

  // Whether `test(corner)` is true of any corner in the cells that the box touches.
  template <typename Test>
  bool any(Vec2f lower, Vec2f upper, const Test& test) const {
    const int x0 = column(lower.x), x1 = column(upper.x);
    for (int y = row(lower.y), y1 = row(upper.y); y <= y1; ++y) {
      for (uint32_t i = first_[cell(x0, y)]; i < first_[cell(x1, y) + 1]; ++i) {
        if (test(sorted_[i])) {
          return true;
        }
      }
    }
    return false;
  }

 private:
  // Monotone for all floats; what is not a number (a polygon without width) is in the first cell.
  int index(float at) const {
    return at > 0.0f ? (at < static_cast<float>(side_) ? static_cast<int>(at) : side_ - 1) : 0;
  }
  int column(float x) const { return index((x - lower_.x) * scale_.x); }
  int row(float y) const { return index((y - lower_.y) * scale_.y); }
  size_t cell(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(side_) + static_cast<size_t>(x);
  }

  std::span<const Vec2f> points_;
  int side_ = 1;
  Vec2f lower_, scale_;
  std::vector<uint32_t> first_, sorted_;
};

// Cuts ears off a polygon: corners whose triangle holds no other corner. Only corners that are not
// convex can lie in one (Eberly, "Triangulation by Ear Clipping"); they are found by a grid.
class EarCutter {
 public:
  explicit EarCutter(std::span<const Vec3f> polygon)
      : q_(project(polygon)), before_(q_.size()), after_(q_.size()), dented_(q_.size()) {
    const auto count = static_cast<uint32_t>(q_.size());
    std::vector<uint32_t> dents;
    for (uint32_t i = 0; i < count; ++i) {
      before_[i] = (i + count - 1) % count;
      after_[i] = (i + 1) % count;
      dented_[i] = is_dented(i);
      if (dented_[i]) {
        dents.push_back(i);
      }
    }
    grid_.emplace(q_, dents);
    budget_ = kWorkPerCorner * q_.size();
  }

  void run(std::vector<std::array<uint32_t, 3>>& triangles) {
    size_t left = q_.size();
    size_t refused = 0;  // corners looked at since the last ear
    uint32_t at = 0;
    while (left > 3) {
      // A polygon that crosses itself may have no ear, or hide them well. Then any corner is cut,
      // and when the budget is spent, all of the rest: a fan about one corner.
      if (refused >= left || budget_ == 0 || is_ear(at)) {
        triangles.push_back({before_[at], at, after_[at]});
        const uint32_t a = before_[at], c = after_[at];
        dented_[at] = false;
        after_[a] = c;
        before_[c] = a;
        dented_[a] = dented_[a] && is_dented(a);
        dented_[c] = dented_[c] && is_dented(c);
        at = budget_ == 0 ? c : a;
        --left;
        refused = 0;
      } else {
        at = after_[at];
        ++refused;
      }
    }
    triangles.push_back({before_[at], at, after_[at]});
  }

 private:
  // Corners looked at, for each of the polygon's, before the rest becomes a fan. Outlines that do
  // not cross themselves take some tens.
  static constexpr size_t kWorkPerCorner = 1000;

  bool is_dented(uint32_t i) const {
    return !(orientation(q_[before_[i]], q_[i], q_[after_[i]]) > 0.0f);
  }

  bool is_ear(uint32_t at) {
    spend();
    const uint32_t before = before_[at], after = after_[at];
    const Vec2f a = q_[before], b = q_[at], c = q_[after];
    if (!(orientation(a, b, c) > 0.0f)) {
      return false;
    }
    const Vec2f lower{std::min({a.x, b.x, c.x}), std::min({a.y, b.y, c.y})};
    const Vec2f upper{std::max({a.x, b.x, c.x}), std::max({a.y, b.y, c.y})};
    return !grid_->any(lower, upper, [&](uint32_t i) {
      spend();
      return dented_[i] && i != before && i != after && contains(a, b, c, q_[i]);
    });
  }
  void spend() { budget_ -= budget_ > 0 ? 1 : 0; }

  std::vector<Vec2f> q_;
  std::vector<uint32_t> before_, after_;  // the corners that are left, as a ring
  std::vector<bool> dented_;              // left, and not convex
  std::optional<CornerGrid> grid_;        // of those dented in the beginning
  size_t budget_ = 0;
};

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
    EarCutter(polygon).run(triangles);
  }
}

}  // namespace vernier
