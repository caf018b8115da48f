#include "render/batch_plan.h"

#include <algorithm>
#include <array>
#include <bit>

#include "math/rng.h"

namespace vernier {
namespace {

// Larger batches would make cancelling slow and change nothing.
constexpr uint64_t kLargestBatch = 64;

uint32_t next_size(uint32_t before, const BatchRules& rules) {
  return rules.single_samples ? 1 : batch_samples(before, rules.share);
}

// Points of each net that a render of `samples` takes, as a power of two.
int room_for(uint32_t samples, const BatchRules& rules) {
  std::array<uint32_t, 2> points{};
  bool second = false;
  for (uint32_t first = 0; first < samples; second = !second) {
    const uint32_t size = std::min(next_size(first, rules), samples - first);
    points[second ? 1 : 0] += size;
    first += size;
  }
  return static_cast<int>(std::bit_width(std::max(points[0], 1u) - 1u));
}

}  // namespace

uint32_t batch_samples(uint64_t total_before, uint32_t share) {
  const uint64_t size = std::bit_floor(std::max<uint64_t>(total_before / share, 1));
  return static_cast<uint32_t>(std::min(size, kLargestBatch));
}

BatchPlan::BatchPlan(uint64_t seed, uint32_t samples, uint32_t planned, const BatchRules& rules)
    : seed_(seed), samples_(samples), log2_capacity_(room_for(planned, rules)) {
  capacity_ = 1u << log2_capacity_;
  alike_size_ =
      std::min(rules.single_samples ? 1 : static_cast<uint32_t>(kLargestBatch), capacity_);
  while (alike_.first < samples_) {
    const uint32_t size = std::min(next_size(alike_.first, rules), capacity_);
    if (size == alike_size_) {
      break;
    }
    const uint32_t taken = std::min(size, samples_ - alike_.first);
    growing_.push_back(batch(alike_, taken));
    alike_.take(taken);
  }
  size_ = growing_.size() + (samples_ - alike_.first + alike_size_ - 1) / alike_size_;
}

Batch BatchPlan::operator[](uint64_t number) const {
  if (number < growing_.size()) {
    return growing_[number];
  }
  const uint64_t after = number - growing_.size();
  // Batches of both nets take turns, beginning with that of alike_.
  const auto of_other = static_cast<uint32_t>(after / 2);
  const auto of_first = static_cast<uint32_t>(after) - of_other;
  Next next = alike_;
  next.first += static_cast<uint32_t>(after) * alike_size_;
  next.points[alike_.second ? 1 : 0] += of_first * alike_size_;
  next.points[alike_.second ? 0 : 1] += of_other * alike_size_;
  next.second = alike_.second != (after % 2 == 1);
  return batch(next, std::min(alike_size_, samples_ - next.first));
}

Batch BatchPlan::batch(const Next& next, uint32_t size) const {
  const uint32_t point = next.points[next.second ? 1 : 0];
  const uint64_t net = 2 * static_cast<uint64_t>(point / capacity_) + (next.second ? 1 : 0);
  return {.seed = net == 0 ? seed_ : hash64(seed_ + net),
          .first = next.first,
          .samples = size,
          .point = point % capacity_,
          .log2_capacity = log2_capacity_,
          .second_net = next.second};
}

}  // namespace vernier
