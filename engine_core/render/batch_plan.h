// The batches of a render.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace vernier {

// A batch is a pass over the whole frame: `samples` more of every pixel, after the `first` that
// batches before it have taken. Two nets of scrambled points take turns, a batch each: what they
// differ by tells how far either is off (error_map.h). The batch's points are those from `point` on
// of a net that `seed` scrambles and that has room for 2^log2_capacity.
struct Batch {
  uint64_t seed = 0;
  uint32_t first = 0;
  uint32_t samples = 1;
  uint32_t point = 0;
  int log2_capacity = 0;
  bool second_net = false;
};

// Samples of the batch that follows `total_before` samples: batches grow with what has been
// rendered, so that the first picture comes at once and the error estimate has at least eight
// batches to go by once there are eight samples. All are powers of two, and so are aligned blocks
// of their net. A batch is no more than 1 / `share` of what was before.
uint32_t batch_samples(uint64_t total_before, uint32_t share = 4);

struct BatchRules {
  uint32_t share = 4;           // see batch_samples
  bool single_samples = false;  // batches do not grow: each is one sample per pixel
};

// The batches of a render, in order. Those that are alike at its end, millions of them where time
// alone ends it, take no memory.
class BatchPlan {
 public:
  // Batches of `samples` per pixel in all. `planned`: how many samples the render was begun for,
  // which alone decides on its points, so that a render that goes on later has those it would have
  // had. More than were planned come from further nets.
  BatchPlan(uint64_t seed, uint32_t samples, uint32_t planned, const BatchRules& rules);

  uint64_t size() const { return size_; }
  Batch operator[](uint64_t number) const;
  // Keeps the first `size` of them, which is no more than there are.
  void shorten(uint64_t size) { size_ = size; }

 private:
  // Sizes of the batches of one net after the other, and points that each net has given before.
  struct Next {
    uint32_t first = 0;
    std::array<uint32_t, 2> points{};
    bool second = false;

    void take(uint32_t size) {
      first += size;
      points[second ? 1 : 0] += size;
      second = !second;
    }
  };
  Batch batch(const Next& next, uint32_t size) const;

  uint64_t seed_;
  uint32_t samples_, capacity_;
  int log2_capacity_;
  std::vector<Batch> growing_;
  Next alike_;               // the first of those that are alike
  uint32_t alike_size_ = 1;  // the last may be smaller
  uint64_t size_ = 0;
};

}  // namespace vernier
