// What a film saves of itself, and how it goes on from there.
#include "render/film.h"
#include "render/state_file.h"

namespace vernier {

void Film::save(StateWriter& state) const {
  // A frame of splats is there as a whole or not at all.
  std::unique_lock frames(frames_lock_);
  frame_added_.wait(frames, [this] { return !adding_frame_; });
  state.add(width_);
  state.add(height_);
  state.add(passes_);
  state.add(splatting_);
  const auto channels = static_cast<size_t>(sampled_channels(passes_));
  for (size_t i = 0; i < tiles_.size(); ++i) {
    const Tile& t = tiles_[i];
    const std::lock_guard lock(locks_[i]);
    state.add(counts_[i]);
    for (int y = t.y; y < t.y + t.height; ++y) {
      const size_t first =
          static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(t.x);
      const size_t end = first + static_cast<size_t>(t.width);
      state.add_all(std::span(pixels_).subspan(first, end - first));
      state.add_all(std::span(values_).subspan(first * channels, (end - first) * channels));
    }
  }
}

void Film::load(StateReader& state) {
  int width = 0, height = 0;
  PassSet passes;
  bool splatting = false;
  state.get(width);
  state.get(height);
  state.get(passes);
  state.get(splatting);
  if (width != width_ || height != height_) {
    state.refuse("is of a picture of another size");
  }
  if (!(passes == passes_) || splatting != splatting_) {
    state.refuse("is of a render with other passes");
  }
  const auto channels = static_cast<size_t>(sampled_channels(passes_));
  for (size_t i = 0; i < tiles_.size(); ++i) {
    const Tile& t = tiles_[i];
    const std::lock_guard lock(locks_[i]);
    state.get(counts_[i]);
    arrivals_[i].next = counts_[i].batches;
    pixel_samples_ +=
        static_cast<uint64_t>(t.width) * static_cast<uint64_t>(t.height) * counts_[i].samples;
    for (int y = t.y; y < t.y + t.height; ++y) {
      const size_t first =
          static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(t.x);
      const size_t end = first + static_cast<size_t>(t.width);
      state.get_all(std::span(pixels_).subspan(first, end - first));
      state.get_all(std::span(values_).subspan(first * channels, (end - first) * channels));
    }
  }
  next_frame_ = counts_.front().batches;
}

}  // namespace vernier
