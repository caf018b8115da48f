// A render in progress: its threads, its film, and what may be asked of it meanwhile.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "integrators/integrator.h"
#include "method_choice/method_choice.h"
#include "render/film.h"
#include "render/light_pass_queue.h"
#include "render/schedule.h"
#include "render/settings.h"
#include "render/state_file.h"
#include "scene/scene.h"

namespace vernier {

// What ended a render.
enum class Ending { kNone, kSamples, kTarget, kTime, kCancelled, kFailed };

struct Progress {
  double samples = 0;  // per pixel, on average
  double samples_target = 0;
  double seconds = 0;
  double seconds_left = 0;  // an estimate; infinite where there is none yet
  double error = 0;         // of the picture (accuracy/statement.h); infinite while unknown
  uint64_t rays = 0;
  uint64_t non_finite = 0;
  bool done = false;
  bool cancelled = false;
  Ending ending = Ending::kNone;  // none while it is not done
};

// Where a render goes on from.
struct Resumption {
  std::string path;   // of the state; empty: it starts anew
  std::string scene;  // a digest of the scene: the state must have been saved with the same
};

class Session {
 public:
  // `give_way`: its threads leave the processor to threads of ordinary priority when these want it.
  // With Auto the render begins with a trial of the methods (method_choice/method_choice.h), but
  // not where it gives way: somebody waits for the picture then. Throws std::bad_alloc when the
  // film does not fit into memory.
  // `resumption`: samples, time and target may differ from those of the state's render, and time
  // counts anew; all else must be equal. Throws std::runtime_error where it is not, or the file is
  // no good.
  Session(std::shared_ptr<const Scene> scene, const Settings& settings, PassSet passes,
          bool give_way = false, const Resumption& resumption = {});
  // Cancels and waits for the threads.
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  // Once. Throws std::logic_error the second time, std::system_error or std::bad_alloc when no
  // thread can be made. At the time limit the threads are stopped as by cancel().
  void start();
  // Asks the threads to stop; each does so within a pixel's samples.
  void cancel();
  // True when no thread runs (before start(), too); waits at most `seconds`.
  bool wait(double seconds);
  // `with_error`: also compute the error, which reads the whole film.
  Progress poll(bool with_error) const;
  // Writes the state of the render (state_file.h), at any time. `scene`: see Resumption.
  void save(const std::string& path, const std::string& scene) const;
  // Tiles that have changed since the last call.
  std::vector<Tile> take_tiles();
  // Why Auto chose the method that renders; empty where the settings name one, and while methods
  // are tried.
  std::string choice() const;
  // Auto while methods are tried.
  IntegratorKind integrator() const;
  // What the method leaves out in this scene, a sentence each.
  // Once it has begun there may be more of them.
  std::vector<std::string> notes() const;
  // Empty, or why the render ended early.
  std::string error_message() const;

  const Film& film() const { return film_; }
  const Scene& scene() const { return *scene_; }
  int thread_count() const { return thread_count_; }

 private:
  using Clock = std::chrono::steady_clock;

  // What the choice of a method decides on.
  struct Method {
    Kernel kernel;
    BatchPlan plan;
    LightPassQueue light_passes;

    Method(Kernel&& chosen, const Settings& settings, const Session& session);
  };

  // From here on the method is known.
  void settle(MethodChoice&& choice);
  // By the first thread that comes, before any asks for a job; others wait for it. It tries methods
  // where that is left to do, and lets the one that renders prepare. There is none where the render
  // was stopped meanwhile.
  void prepare(const RenderContext& context, RenderStats& stats);
  void work(int thread);
  void watch_the_time();
  void thread_ended(int count);
  // Notes pixels that time left none for. Under mutex_.
  void tell_what_is_empty() noexcept;
  // Takes in what the method has found out beforehand; before any thread asks for a job.
  void heed(const Plan& plan);
  double elapsed() const;
  void stop(Ending ending);
  // What every tile is to have next, by what the film says of the picture.
  Schedule::Round look();
  // Reads the state's own part, and of a render by Auto its method.
  Settings resumed(const Settings& given, const std::string& scene);
  // The number of the batch that a tile ends before which has `begun` batches now.
  uint64_t next_look(uint64_t begun) const;

  std::shared_ptr<const Scene> scene_;
  std::unique_ptr<StateReader> state_;  // while it is read
  uint32_t planned_samples_ = 0;        // what the render was begun for; 0: it begins now
  unsigned looks_ = 0;                  // at the picture's error
  Settings settings_;                   // those given, until the method is chosen
  std::string choice_;
  PassSet passes_;
  Film film_;
  PixelFilter2d filter_;
  std::unique_ptr<Method> method_;  // null until it is chosen
  std::mutex preparing_;
  bool prepared_ = false;  // under that lock
  std::unique_ptr<const Plan> plan_of_method_;
  int thread_count_;
  bool give_way_;
  std::vector<std::thread> threads_;
  std::thread watch_;  // only with a time limit
  std::vector<RenderStats> stats_;
  std::vector<std::atomic<uint64_t>> rays_;
  std::unique_ptr<Schedule> schedule_;
  std::atomic<uint64_t> non_finite_{0};
  std::atomic<bool> cancelled_{false};
  std::atomic<bool> stopped_{false};  // cancelled, out of time, or failed
  std::atomic<Ending> ending_{Ending::kNone};
  std::atomic<int> running_{0};
  Clock::time_point start_;
  std::atomic<bool> started_{false};
  std::atomic<int64_t> end_nanoseconds_{-1};
  mutable std::mutex mutex_;
  std::condition_variable finished_;
  std::string error_message_;
  std::vector<std::string> late_notes_;
  std::vector<bool> changed_;
};

}  // namespace vernier
