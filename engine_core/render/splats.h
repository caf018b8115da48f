// Light that arrives anywhere in the frame, whichever pixel's sample it belongs to.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <vector>

#include "math/vec.h"

namespace vernier {

// Sums of one batch over the frame. Any thread may add at any time; the order of the sums, and so
// their last bits in float64, are left to chance.
class SplatFrame {
 public:
  // Planes of the sums: the picture, and where asked for what each light pass has of it.
  static constexpr size_t kDirectPlane = 1, kIndirectPlane = 4, kPlanesWithPasses = 7;

  SplatFrame(int width, int height, bool passes)
      : width_(static_cast<size_t>(width)),
        size_(width_ * static_cast<size_t>(height)),
        sums_(size_ * (passes ? kPlanesWithPasses : 1) * 3) {}

  void add(int x, int y, Color c) { add_to(0, pixel(x, y), c); }
  // Also to the passes: `shares` of diffuse, glossy and transmission.
  void add(int x, int y, Color c, const std::array<Color, 3>& shares, bool direct) {
    const size_t at = pixel(x, y);
    add_to(0, at, c);
    for (size_t group = 0; group < shares.size(); ++group) {
      add_to((direct ? kDirectPlane : kIndirectPlane) + group, at, c * shares[group]);
    }
  }

  bool has_passes() const { return sums_.size() > size_ * 3; }
  // RGB; to be read when nothing is added any more.
  const double* sum(size_t plane, size_t pixel) const {
    return sums_.data() + (plane * size_ + pixel) * 3;
  }

 private:
  size_t pixel(int x, int y) const {
    return static_cast<size_t>(y) * width_ + static_cast<size_t>(x);
  }
  void add_to(size_t plane, size_t pixel, Color c) {
    double* at = sums_.data() + (plane * size_ + pixel) * 3;
    for (int i = 0; i < 3; ++i) {
      if (c[i] != 0.0f) {
        std::atomic_ref<double>(at[i]).fetch_add(static_cast<double>(c[i]),
                                                 std::memory_order_relaxed);
      }
    }
  }

  size_t width_, size_;
  std::vector<double> sums_;
};

}  // namespace vernier
