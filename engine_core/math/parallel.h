// Loops over independent items on several threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace vernier {

inline int resolve_threads(int threads) {
  return threads > 0 ? threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

// Calls body(i) for i in [0, count), in any order, on up to `threads` threads (0: all there are).
// The first exception that a call throws is thrown here, after the others have stopped.
template <typename Body>
void parallel_for(size_t count, int threads, const Body& body) {
  std::atomic<size_t> next{0};
  std::exception_ptr failure;
  std::mutex failure_mutex;
  const auto work = [&] {
    try {
      for (size_t i = next++; i < count; i = next++) {
        body(i);
      }
    } catch (...) {
      const std::lock_guard lock(failure_mutex);
      if (!failure) {
        failure = std::current_exception();
      }
      next = count;
    }
  };
  const size_t workers = std::min(count, static_cast<size_t>(resolve_threads(threads)));
  std::vector<std::thread> others;
  others.reserve(workers);
  try {
    for (size_t i = 1; i < workers; ++i) {
      others.emplace_back(work);
    }
  } catch (const std::exception&) {
    // The system has no more threads, or no memory for them: those that there are do the work.
  }
  work();
  for (std::thread& thread : others) {
    thread.join();
  }
  if (failure) {
    std::rethrow_exception(failure);
  }
}

}  // namespace vernier
