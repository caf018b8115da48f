// From a triangle that a ray hit to the number of its light.
#pragma once

#include <bit>
#include <cstdint>
#include <vector>

#include "scene/surface_point.h"

namespace vernier {

// Emissive triangles are numbered by instance, then by triangle. An instance all of which shines
// takes 8 bytes here, any other with a light 1.5 bits per triangle more: a bit each, and the
// number of bits before each word.
class TriangleIndex {
 public:
  // Instances are added in order; `emissive[i]` tells whether triangle i of this one is a light.
  void add_instance(const std::vector<bool>& emissive);
  // An instance without lights.
  void add_dark_instance() { instances_.push_back({next_light_, kDark}); }

  // kNoIndex where the triangle is no light.
  uint32_t find(uint32_t instance, uint32_t triangle) const {
    if (instance >= instances_.size()) {
      return kNoIndex;
    }
    const Entry entry = instances_[instance];
    if (entry.words == kDark) {
      return kNoIndex;
    }
    if (entry.words == kFull) {
      return entry.first_light + triangle;
    }
    const Word& word = words_[entry.words + triangle / 64u];
    const uint64_t bit = uint64_t{1} << (triangle % 64u);
    if ((word.bits & bit) == 0) {
      return kNoIndex;
    }
    return entry.first_light + word.before +
           static_cast<uint32_t>(std::popcount(word.bits & (bit - 1u)));
  }

 private:
  static constexpr uint32_t kDark = 0xffffffffu, kFull = 0xfffffffeu;
  struct Entry {
    uint32_t first_light;
    uint32_t words;  // first word of it, or kDark or kFull
  };
  struct Word {
    uint64_t bits = 0;
    uint32_t before = 0;  // lights of this instance in earlier words
  };
  std::vector<Entry> instances_;
  std::vector<Word> words_;
  uint32_t next_light_ = 0;
};

inline void TriangleIndex::add_instance(const std::vector<bool>& emissive) {
  uint32_t count = 0;
  const auto first_word = static_cast<uint32_t>(words_.size());
  for (size_t i = 0; i < emissive.size(); ++i) {
    if (i % 64 == 0) {
      words_.push_back({0, count});
    }
    if (emissive[i]) {
      words_.back().bits |= uint64_t{1} << (i % 64);
      ++count;
    }
  }
  Entry entry{next_light_, first_word};
  if (count == 0 || count == emissive.size()) {
    words_.resize(first_word);
    entry.words = count == 0 ? kDark : kFull;
  }
  instances_.push_back(entry);
  next_light_ += count;
}

}  // namespace vernier
