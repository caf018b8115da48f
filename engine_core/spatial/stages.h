// Work in stages: the jobs of one stage may run at once, on any threads; a stage starts when all
// jobs of the one before have ended.
#pragma once

#include <cstddef>

#include "math/parallel.h"

namespace vernier {

// Runs all of `work` on up to `threads` threads (0: all there are). `work` has
//   int stages() const;
//   size_t jobs(int stage) const;  asked when the stage starts
//   void run(int stage, size_t job).
// A render's threads may take the same jobs between their own instead.
template <class Work>
void run_stages(Work& work, int threads) {
  for (int stage = 0; stage < work.stages(); ++stage) {
    parallel_for(work.jobs(stage), threads, [&](size_t job) { work.run(stage, job); });
  }
}

}  // namespace vernier
