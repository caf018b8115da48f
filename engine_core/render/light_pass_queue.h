// Light passes of a render, made by all of its threads together.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "integrators/integrator.h"

namespace vernier {

// A thread that wants to render a tile of a batch asks for the batch's light pass, and takes part
// in making it until it is there. Threads that still render tiles of an earlier batch join later.
class LightPassQueue {
 public:
  // `begun`: the number of each tile's first batch. From then on every tile asks for the light pass
  // of every batch; the last one to ask frees it.
  LightPassQueue(const Kernel& kernel, const BatchPlan& batches, std::vector<uint64_t> begun)
      : kernel_(kernel), batches_(batches), begun_(std::move(begun)) {}

  // Makes `pass` the light pass of batch `number`; null where it needs none. False when the render
  // has been stopped. What a job throws leaves from here, and the other threads get false: the
  // caller stops the render then.
  bool get(const RenderContext& context, uint64_t number, RenderStats& stats,
           std::shared_ptr<const LightPass>& pass);

 private:
  struct Making {
    std::shared_ptr<LightPass> pass;
    int stage = 0;
    size_t next = 0, done = 0, jobs = 0;  // of the stage
    size_t asked = 0;
    bool failed = false;

    bool complete = false;

    // To the first stage from `stage` on that has jobs; when no job runs.
    void begin_stage();
  };

  // How many tiles ask for batch `number`.
  size_t tiles(uint64_t number) const;
  std::shared_ptr<Making> find(const RenderContext& context, uint64_t number);

  const Kernel& kernel_;
  const BatchPlan& batches_;
  std::vector<uint64_t> begun_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<uint64_t, std::shared_ptr<Making>> makings_;  // by batch
};

}  // namespace vernier
