#include "render/light_pass_queue.h"

#include <algorithm>

namespace vernier {

void LightPassQueue::Making::begin_stage() {
  next = done = jobs = 0;
  const int stages = pass == nullptr ? 0 : pass->stages();
  while (stage < stages && (jobs = pass->jobs(stage)) == 0) {
    ++stage;
  }
  complete = stage == stages;
}

size_t LightPassQueue::tiles(uint64_t number) const {
  return static_cast<size_t>(
      std::count_if(begun_.begin(), begun_.end(), [&](uint64_t b) { return b <= number; }));
}

std::shared_ptr<LightPassQueue::Making> LightPassQueue::find(const RenderContext& context,
                                                             uint64_t number) {
  std::shared_ptr<Making>& entry = makings_[number];
  if (entry == nullptr) {
    auto making = std::make_shared<Making>();
    making->pass = kernel_.make_light_pass(context, batches_[number]);
    making->begin_stage();
    entry = std::move(making);
  }
  std::shared_ptr<Making> found = entry;
  if (++found->asked == tiles(number)) {
    makings_.erase(number);
  }
  return found;
}

bool LightPassQueue::get(const RenderContext& context, uint64_t number, RenderStats& stats,
                         std::shared_ptr<const LightPass>& pass) {
  std::unique_lock lock(mutex_);
  const std::shared_ptr<Making> making = find(context, number);
  while (!making->complete) {
    if (making->failed || context.cancelled) {
      return false;
    }
    if (making->next == making->jobs) {
      // Whoever is at work tells when it is done, cancelled or not.
      changed_.wait(lock);
      continue;
    }
    const int stage = making->stage;
    const size_t job = making->next++;
    lock.unlock();
    try {
      making->pass->run(stage, job, context, stats);
    } catch (...) {
      lock.lock();
      making->failed = true;
      changed_.notify_all();
      throw;
    }
    lock.lock();
    // A job that was cut short makes no stage complete.
    making->failed = making->failed || context.cancelled;
    if (++making->done == making->jobs && !making->failed) {
      ++making->stage;
      making->begin_stage();
    }
    changed_.notify_all();
  }
  pass = making->pass;
  return true;
}

}  // namespace vernier
