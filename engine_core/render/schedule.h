// Which thread renders what next, and when the render looks at what it has.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <vector>

namespace vernier {

// Batch number `batch` of tile number `tile`.
struct Job {
  size_t tile = 0;
  uint64_t batch = 0;
};

// A render goes in rounds. A round gives every tile batches up to a number of its own; when all are
// in the film, the render looks at it and decides on the next round. So what is decided depends on
// the picture alone, never on the threads.
class Schedule {
 public:
  // For every tile the number of the batch that it ends before; empty: the render has ended.
  using Round = std::vector<uint64_t>;
  // Called by one thread while the others wait.
  using Look = std::function<Round()>;

  // `begun`: for every tile the number of its first batch.
  Schedule(std::vector<uint64_t> begun, Look look)
      : next_(std::move(begun)), look_(std::move(look)), until_(next_) {}

  // The next job; the first that is due of those with the smallest batch number. Waits while a
  // round comes to its end. False when the render has ended. Throws what the look throws.
  bool next(Job& job);
  // A job is in the film.
  void done();
  // No more jobs; wakes all that wait.
  void end();

 private:
  bool take(Job& job);
  void begin(Round&& round);

  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<uint64_t> next_;  // by tile: number of the batch to be given out next
  Look look_;
  Round until_;
  uint64_t number_ = 0;  // of the batches that are given out now
  uint64_t last_ = 0;    // the round has none from this number on
  size_t tile_ = 0;
  size_t at_work_ = 0;  // jobs given out and not done
  bool looking_ = false, ended_ = false;
};

}  // namespace vernier
