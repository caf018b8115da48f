#include "spatial/hash_grid.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <utility>

#include "spatial/stages.h"

namespace vernier {
namespace {

// Points of a part, at least, and the number of parts at most. They are those of the points alone:
// threads take them in any order.
constexpr size_t kPartSize = 16384, kMostParts = 64;
// Cells are wider than two radii by this part, for the roundings of a query.
constexpr float kSpare = 0x1p-8f;
// And this many roundings of the largest coordinate wide: a finer grid would tell apart what
// positions cannot, and number its cells beyond what float32 counts exactly.
constexpr float kLeastRoundings = 16.0f;
// A width whose reciprocal is finite, for points that are all in the origin.
constexpr float kLeastWidth = 4.0f * std::numeric_limits<float>::min();

}  // namespace

HashGrid::HashGrid(std::span<const Vec3f> positions, float radius, int threads) {
  HashGridBuild build(*this, positions, radius);
  run_stages(build, threads);
}

HashGridBuild::HashGridBuild(HashGrid& grid, std::span<const Vec3f> positions, float radius)
    : grid_(grid),
      positions_(positions),
      parts_(std::clamp(positions.size() / kPartSize, size_t{1}, kMostParts)),
      low_(parts_, splat(kInfinity)),
      high_(parts_, splat(-kInfinity)) {
  grid_.entries_.clear();
  grid_.radius_ = radius;
  grid_.radius_squared_ = square(radius);
}

size_t HashGridBuild::jobs(int stage) const {
  if (positions_.empty()) {
    return 0;
  }
  switch (static_cast<Stage>(stage)) {
    case Stage::kLayOut:
    case Stage::kAddUp:
      return 1;
    case Stage::kSort:
      return regions_;
    default:
      return parts_;
  }
}

void HashGridBuild::run(int stage, size_t job) {
  switch (static_cast<Stage>(stage)) {
    case Stage::kBound:
      return bound(job);
    case Stage::kLayOut:
      return lay_out();
    case Stage::kCount:
      return count(job);
    case Stage::kAddUp:
      return add_up();
    case Stage::kSpread:
      return spread(job);
    case Stage::kSort:
      return sort(job);
    case Stage::kStages:
      return;
  }
}

void HashGridBuild::bound(size_t part) {
  Vec3f low = splat(kInfinity), high = splat(-kInfinity);
  for (size_t i = part_begin(part); i < part_begin(part + 1); ++i) {
    low = min(low, positions_[i]);
    high = max(high, positions_[i]);
  }
  low_[part] = low;
  high_[part] = high;
}

void HashGridBuild::lay_out() {
  Vec3f low = low_.front(), high = high_.front();
  for (size_t part = 1; part < parts_; ++part) {
    low = min(low, low_[part]);
    high = max(high, high_[part]);
  }
  const float largest = max_component(max(abs(low), abs(high)));
  const float width = std::max({2.0f * grid_.radius_ * (1.0f + kSpare),
                                largest * (kLeastRoundings * kUnitRoundoff), kLeastWidth});
  grid_.origin_ = low;
  grid_.inverse_width_ = 1.0f / width;
  for (int axis = 0; axis < 3; ++axis) {
    grid_.last_[static_cast<size_t>(axis)] = grid_.cell(high[axis], axis);
  }
  const size_t buckets = std::bit_ceil(positions_.size());
  const int bits = std::bit_width(buckets) - 1;
  const int region_bits = std::min(bits, kMostRegionBits);
  grid_.mask_ = static_cast<uint32_t>(buckets - 1);
  region_shift_ = bits - region_bits;
  regions_ = size_t{1} << region_bits;
  grid_.entries_.resize(positions_.size());
  grid_.starts_.resize(buckets + 1);
  buckets_.resize(positions_.size());
  order_.resize(positions_.size());
  counts_.assign(parts_ * regions_, 0);
  region_starts_.resize(regions_ + 1);
}

void HashGridBuild::count(size_t part) {
  uint32_t* counts = &counts_[part * regions_];
  for (size_t i = part_begin(part); i < part_begin(part + 1); ++i) {
    buckets_[i] = grid_.bucket(positions_[i]);
    ++counts[region(buckets_[i])];
  }
}

// Of counts makes places: regions in their order, and in each the parts in theirs.
void HashGridBuild::add_up() {
  uint32_t place = 0;
  for (size_t r = 0; r < regions_; ++r) {
    region_starts_[r] = place;
    for (size_t part = 0; part < parts_; ++part) {
      place += std::exchange(counts_[part * regions_ + r], place);
    }
  }
  region_starts_[regions_] = place;
}

void HashGridBuild::spread(size_t part) {
  uint32_t* places = &counts_[part * regions_];
  for (size_t i = part_begin(part); i < part_begin(part + 1); ++i) {
    order_[places[region(buckets_[i])]++] = static_cast<uint32_t>(i);
  }
}

// A counting sort of the region's points by bucket, stable: by index within each.
void HashGridBuild::sort(size_t region) {
  const size_t first_bucket = region << region_shift_;
  const size_t size = size_t{1} << region_shift_;
  uint32_t* starts = &grid_.starts_[first_bucket];
  std::fill_n(starts, size, 0u);
  const uint32_t begin = region_starts_[region], end = region_starts_[region + 1];
  for (uint32_t i = begin; i < end; ++i) {
    ++starts[buckets_[order_[i]] - first_bucket];
  }
  // Of counts makes the ends of the buckets, and filling from behind turns these into starts.
  uint32_t place = begin;
  for (size_t b = 0; b < size; ++b) {
    place += starts[b];
    starts[b] = place;
  }
  for (uint32_t i = end; i-- > begin;) {
    const uint32_t index = order_[i];
    grid_.entries_[--starts[buckets_[index] - first_bucket]] = {positions_[index], index};
  }
  if (region + 1 == regions_) {
    grid_.starts_.back() = end;
  }
}

}  // namespace vernier
