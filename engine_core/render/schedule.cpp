#include "render/schedule.h"

#include <algorithm>

namespace vernier {

bool Schedule::take(Job& job) {
  for (; number_ < last_; ++number_, tile_ = 0) {
    for (; tile_ < next_.size(); ++tile_) {
      if (next_[tile_] == number_ && number_ < until_[tile_]) {
        job = {tile_, next_[tile_]++};
        ++tile_;
        return true;
      }
    }
  }
  return false;
}

void Schedule::begin(Round&& round) {
  until_ = std::move(round);
  ended_ = ended_ || until_.empty();
  if (ended_) {
    return;
  }
  number_ = *std::min_element(next_.begin(), next_.end());
  last_ = *std::max_element(until_.begin(), until_.end());
  tile_ = 0;
}

bool Schedule::next(Job& job) {
  std::unique_lock lock(mutex_);
  while (!ended_) {
    if (!looking_ && take(job)) {
      ++at_work_;
      return true;
    }
    if (looking_ || at_work_ > 0) {
      changed_.wait(lock);
      continue;
    }
    looking_ = true;
    lock.unlock();
    Round round = look_();
    lock.lock();
    looking_ = false;
    begin(std::move(round));
    changed_.notify_all();
  }
  return false;
}

void Schedule::done() {
  const std::lock_guard lock(mutex_);
  if (--at_work_ == 0) {
    changed_.notify_all();
  }
}

void Schedule::end() {
  const std::lock_guard lock(mutex_);
  ended_ = true;
  changed_.notify_all();
}

}  // namespace vernier
