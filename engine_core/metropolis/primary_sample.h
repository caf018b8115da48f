// Primary-sample space: the numbers that a path is made from, as the coordinates of a chain
// (Kelemen et al. 2002, "A Simple and Robust Mutation Strategy for the Metropolis Light Transport
// Algorithm").
//
// A coordinate exists only while the current path has read it. A proposal moves the coordinates
// that it shares with the current path, and draws those afresh that are its own: by either way the
// density is the same there and back. So a proposal costs what its path reads, and nothing is kept
// for vertices that are not there (mutation is lazy).
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "math/rng.h"
#include "math/vec.h"
#include "sampling/dimensions.h"
#include "sampling/sobol.h"

namespace vernier {

// A choice that is made before the path.
inline constexpr uint32_t kChoiceDimension = 0xffffffffu;
// The numbers of what goes on from a path by a guide come after those of all walks.
inline constexpr uint32_t kFirstGuideDimension = 1u << 31;

// Moves u within [0,1), around its ends, by a distance between 1/1024 and 1/16 to either side: in
// each octave equally often, and there uniform (about as Kelemen et al. 2002, section 3.2, who end
// at 1/64: measured, that mixes more slowly). `bits` are random.
inline float small_step(float u, uint32_t bits) {
  constexpr uint32_t kOctaves = 6, kLargestExponent = 127 - 5;  // [1/32, 1/16)
  // A float of 23 random bits, of an exponent by 8 others, and a sign.
  const uint32_t exponent = kLargestExponent - ((((bits >> 1) & 0xffu) * kOctaves) >> 8);
  const auto step = std::bit_cast<float>((bits << 31) | (exponent << 23) | (bits >> 9));
  const float moved = u + step;
  // Once around; what rounds to 1 is 0.
  const float turned = moved < 0.0f ? moved + 1.0f : moved;
  return turned < 1.0f ? turned : turned - 1.0f;
}

// The one of `count` equal parts of [0,1) that u is in.
inline int part_of(float u, int count) {
  return std::min(static_cast<int>(u * static_cast<float>(count)), count - 1);
}

// The point at `within`, of [0,1), of part number `part`: exactly there by part_of(), however it is
// rounded.
inline float point_of_part(int part, int count, float within) {
  const float u = (static_cast<float>(part) + within) / static_cast<float>(count);
  float inside = std::min(u, kOneMinusEpsilon);
  while (part_of(inside, count) > part) {
    inside = std::nextafter(inside, 0.0f);
  }
  while (part_of(inside, count) < part) {
    inside = std::nextafter(inside, 1.0f);
  }
  return inside;
}

class PrimarySamples {
 public:
  // The stream of numbers that proposals are drawn with.
  void seed(uint64_t seed) { rng_ = Pcg32(seed); }
  // Begins a point that is read from `source`, which outlives its evaluation. Nothing is current.
  void begin(const SobolSampler& source) {
    current_ = ++stamp_;
    begin_proposal(&source, true);
  }
  // Begins a proposal: coordinates are drawn as they are read.
  void propose(bool large) { begin_proposal(nullptr, large); }
  // The proposal is now current.
  void accept() {
    current_ = ++stamp_;
    for (Stream& stream : streams_) {
      for (const uint32_t i : stream.touched) {
        Coordinate& c = stream.coordinates[i];
        c.value = c.proposed;
        c.current_stamp = current_;
      }
    }
  }
  // A number that is no coordinate.
  float random() { return rng_.next_float(); }

  // Gives the choice of the point that begins a value.
  void choose(Vec2f value) {
    Coordinate& c = coordinate(streams_[kChoice], 0);
    c.proposed = value;
    touch(streams_[kChoice], c, 0);
  }

  // The proposal's point for the pair of dimensions.
  Vec2f get(uint32_t dimension) {
    if (dimension == kChoiceDimension) {
      return read(streams_[kChoice], dimension, 0);
    }
    if (dimension >= kFirstGuideDimension) {
      return read(streams_[kGuide], dimension, dimension - kFirstGuideDimension);
    }
    return dimension >= kFirstLightDimension
               ? read(streams_[kLight], dimension, dimension - kFirstLightDimension)
               : read(streams_[kCamera], dimension, dimension);
  }

 private:
  struct Coordinate {
    Vec2f value, proposed;
    uint64_t current_stamp = 0;   // of the point that `value` belongs to
    uint64_t proposed_stamp = 0;  // of the proposal that `proposed` belongs to
  };
  struct Stream {
    std::vector<Coordinate> coordinates;
    std::vector<uint32_t> touched;  // those that the proposal has read
  };
  enum : size_t { kCamera, kLight, kGuide, kChoice, kStreams };

  void begin_proposal(const SobolSampler* source, bool large) {
    source_ = source;
    large_ = large;
    proposal_ = ++stamp_;
    for (Stream& stream : streams_) {
      stream.touched.clear();
    }
  }

  static Coordinate& coordinate(Stream& stream, uint32_t index) {
    if (index >= stream.coordinates.size()) {
      stream.coordinates.resize(2 * static_cast<size_t>(index) + 16);
    }
    return stream.coordinates[index];
  }
  void touch(Stream& stream, Coordinate& c, uint32_t index) const {
    c.proposed_stamp = proposal_;
    stream.touched.push_back(index);
  }

  Vec2f read(Stream& stream, uint32_t dimension, uint32_t index) {
    Coordinate& c = coordinate(stream, index);
    if (c.proposed_stamp == proposal_) {
      return c.proposed;
    }
    touch(stream, c, index);
    if (source_ != nullptr) {
      c.proposed = source_->get_2d(dimension);
    } else if (large_ || c.current_stamp != current_) {
      c.proposed = {rng_.next_float(), rng_.next_float()};
    } else {
      c.proposed = {small_step(c.value.x, rng_.next()), small_step(c.value.y, rng_.next())};
    }
    return c.proposed;
  }

  Pcg32 rng_{0};
  const SobolSampler* source_ = nullptr;
  std::array<Stream, kStreams> streams_;
  uint64_t stamp_ = 0, current_ = 0, proposal_ = 0;
  bool large_ = true;
};

// Stands where walks expect a sampler.
class PrimarySampler {
 public:
  explicit PrimarySampler(PrimarySamples& samples) : samples_(samples) {}

  Vec2f get_2d(uint32_t dimension) const { return samples_.get(dimension); }
  template <uint32_t kCount>
  std::array<Vec2f, kCount> get_2d_run(uint32_t first) const {
    std::array<Vec2f, kCount> points;
    for (uint32_t i = 0; i < kCount; ++i) {
      points[i] = samples_.get(first + i);
    }
    return points;
  }

 private:
  PrimarySamples& samples_;
};

}  // namespace vernier
