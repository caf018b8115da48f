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

std::vector<Batch> plan_batches(uint64_t seed, uint32_t samples, uint32_t planned,
                                const BatchRules& rules) {
  const int log2_capacity = room_for(planned, rules);
  const uint32_t capacity = 1u << log2_capacity;
  std::array<uint32_t, 2> points{};
  std::vector<Batch> plan;
  bool second = false;
  for (uint32_t first = 0; first < samples; second = !second) {
    const uint32_t size = std::min({next_size(first, rules), capacity, samples - first});
    uint32_t& point = points[second ? 1 : 0];
    const uint64_t net = 2 * static_cast<uint64_t>(point / capacity) + (second ? 1 : 0);
    plan.push_back({.seed = net == 0 ? seed : hash64(seed + net),
                    .first = first,
                    .samples = size,
                    .point = point % capacity,
                    .log2_capacity = log2_capacity,
                    .second_net = second});
    point += size;
    first += size;
  }
  return plan;
}

}  // namespace vernier
