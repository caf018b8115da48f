// Points that lie within a fixed radius, by a hash of cubic cells (Teschner et al. 2003, "Optimized
// Spatial Hashing for Collision Detection of Deformable Objects").
//
// The points are sorted by bucket: a counting sort, so that a query reads short runs of memory and
// there are no lists. A cell is at least twice the radius wide, so that a query meets at most eight
// cells. Two of these may fall into one bucket: a bucket is visited once, and so no point is found
// twice. Cells beside each other along x are beside each other in memory.
//
// Rounding cannot lose a point: the cell of a coordinate is a monotone function of it, and a query
// reaches for all that its test of the distance could accept.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "math/rng.h"
#include "math/vec.h"

namespace vernier {

class HashGrid {
 public:
  // A grid of nothing.
  HashGrid() = default;
  // `positions` finite, each coordinate below 1e18 in size, fewer than 2^32 of them; not kept.
  // `radius` is 0 or between 1e-18 and 1e18. Built on up to `threads` threads (0: all there are);
  // the grid, and the order in which it visits, do not depend on them.
  HashGrid(std::span<const Vec3f> positions, float radius, int threads);

  size_t size() const { return entries_.size(); }
  float radius() const { return radius_; }
  // Bytes in use: 20 to 24 for each point.
  size_t memory() const {
    return entries_.size() * sizeof(Entry) + starts_.size() * sizeof(uint32_t);
  }

  // Calls visit(index, distance_squared) exactly once for each point no farther than the radius
  // from p, with its place in `positions`. The same order for the same grid.
  template <class Visit>
  void for_each(Vec3f p, const Visit& visit) const;

 private:
  friend class HashGridBuild;

  struct Entry {
    Vec3f p;
    uint32_t index;
  };
  // Two along each axis, and room for one more: the bound of the width leaves none to rounding.
  static constexpr size_t kMostCells = 27;

  // The cell of a coordinate, as a whole number of any size: monotone in x.
  float cell(float x, int axis) const { return std::floor((x - origin_[axis]) * inverse_width_); }
  // The first bucket of the cells of one row.
  static uint32_t row(uint32_t y, uint32_t z) {
    return static_cast<uint32_t>(hash64(static_cast<uint64_t>(z) << 32 | y));
  }
  uint32_t bucket(Vec3f p) const {
    return (row(static_cast<uint32_t>(cell(p.y, 1)), static_cast<uint32_t>(cell(p.z, 2))) +
            static_cast<uint32_t>(cell(p.x, 0))) &
           mask_;
  }

  std::vector<Entry> entries_;    // sorted by bucket, and by index within one
  std::vector<uint32_t> starts_;  // of each bucket in `entries_`, and its end
  Vec3f origin_;
  std::array<float, 3> last_{};  // number of the last cell along each axis
  float radius_ = 0, radius_squared_ = 0, inverse_width_ = 0;
  uint32_t mask_ = 0;  // of the number of a bucket: there are mask_ + 1
};

// The grid's construction as stages (stages.h), for threads that have other work as well.
class HashGridBuild {
 public:
  // All three must outlive the build; as HashGrid().
  HashGridBuild(HashGrid& grid, std::span<const Vec3f> positions, float radius);

  int stages() const { return static_cast<int>(Stage::kStages); }
  size_t jobs(int stage) const;
  void run(int stage, size_t job);

 private:
  enum class Stage { kBound, kLayOut, kCount, kAddUp, kSpread, kSort, kStages };
  static constexpr int kMostRegionBits = 8;

  // The points of part number i of parts_.
  size_t part_begin(size_t i) const { return positions_.size() * i / parts_; }
  void bound(size_t part);
  void lay_out();
  void count(size_t part);
  void add_up();
  void spread(size_t part);
  void sort(size_t region);
  size_t region(uint32_t bucket) const { return bucket >> region_shift_; }

  HashGrid& grid_;
  std::span<const Vec3f> positions_;
  size_t parts_, regions_ = 1;  // a region: a run of buckets
  int region_shift_ = 0;
  std::vector<Vec3f> low_, high_;        // bounds of each part
  std::vector<uint32_t> buckets_;        // of each point
  std::vector<uint32_t> counts_;         // of each part and region: points, then where they go
  std::vector<uint32_t> order_;          // points sorted by region
  std::vector<uint32_t> region_starts_;  // in `order_`
};

template <class Visit>
void HashGrid::for_each(Vec3f p, const Visit& visit) const {
  if (entries_.empty()) {
    return;
  }
  // The test below accepts what is at most this far along an axis: each operation rounds once.
  const float reach = radius_ * (1.0f + 16.0f * kUnitRoundoff);
  std::array<uint32_t, 3> first, last;
  for (int axis = 0; axis < 3; ++axis) {
    const float low = p[axis] - reach, high = p[axis] + reach;
    const float from = cell(low - std::abs(low) * (4.0f * kUnitRoundoff), axis);
    const float to = cell(high + std::abs(high) * (4.0f * kUnitRoundoff), axis);
    const float end = last_[static_cast<size_t>(axis)];
    if (!(to >= 0.0f && from <= end)) {
      return;
    }
    first[static_cast<size_t>(axis)] = static_cast<uint32_t>(std::max(from, 0.0f));
    last[static_cast<size_t>(axis)] = static_cast<uint32_t>(std::min(to, end));
  }
  std::array<uint32_t, kMostCells> visited;
  size_t count = 0;
  for (uint32_t z = first[2]; z <= last[2]; ++z) {
    for (uint32_t y = first[1]; y <= last[1]; ++y) {
      const uint32_t start = row(y, z);
      for (uint32_t x = first[0]; x <= last[0]; ++x) {
        const uint32_t b = (start + x) & mask_;
        const uint32_t begin = starts_[b], end = starts_[b + 1];
        bool again = begin == end;
        for (size_t i = 0; i < count; ++i) {
          again = again || visited[i] == b;
        }
        if (again) {
          continue;
        }
        visited[count++] = b;
        for (uint32_t i = begin; i < end; ++i) {
          const float distance_squared = length_squared(entries_[i].p - p);
          if (distance_squared <= radius_squared_) {
            visit(entries_[i].index, distance_squared);
          }
        }
      }
    }
  }
}

}  // namespace vernier
