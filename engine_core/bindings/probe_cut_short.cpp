// A probe of what comes after something was cut short. A session asks for little once it is
// cancelled; here all parts of a render go on with what those before them have left.
#include <nanobind/stl/map.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/variant.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "bindings/bind.h"
#include "bindings/probe_render.h"
#include "math/float_environment.h"
#include "method_choice/method_choice.h"

namespace nb = nanobind;

namespace vernier {
namespace {

// Cancels after some time, or at once where that is 0, unless what is to be cancelled ends before.
class Canceller {
 public:
  Canceller(std::atomic<bool>& cancelled, double seconds) : cancelled_(cancelled) {
    if (seconds > 0.0) {
      thread_ = std::thread([this, seconds] {
        std::unique_lock lock(mutex_);
        over_.wait_for(lock, std::chrono::duration<double>(seconds), [this] { return ended_; });
        cancelled_ = true;
      });
    } else {
      cancelled_ = true;
    }
  }
  ~Canceller() {
    {
      const std::lock_guard lock(mutex_);
      ended_ = true;
    }
    over_.notify_all();
    if (thread_.joinable()) {
      thread_.join();
    }
  }
  Canceller(const Canceller&) = delete;
  Canceller& operator=(const Canceller&) = delete;

 private:
  std::atomic<bool>& cancelled_;
  std::mutex mutex_;
  std::condition_variable over_;
  bool ended_ = false;
  std::thread thread_;
};

// Plan, light pass and one batch of all tiles of a method that is cancelled after `seconds`, by
// this thread and those of the settings. Of Auto: its choice as well. Returns the rays of all.
uint64_t cut_short(nb::handle handle, const std::map<std::string, SettingValue>& values,
                   double seconds) {
  ProbeRender render(handle, values);
  const Scene& scene = *render.scene;
  const nb::gil_scoped_release release;
  const FlushDenormals flush;
  const Canceller canceller(render.cancelled, seconds);
  if (static_cast<IntegratorKind>(render.settings.integrator) == IntegratorKind::kAuto) {
    const MethodChoice choice =
        choose_by_trial(render.scene, render.settings, PassSet(), render.cancelled);
    render.settings.integrator = static_cast<int>(choice.integrator);
  }
  const Kernel kernel = choose_kernel(render.settings, scene.requirements, PassSet());
  Film film(scene.film.crop[2] - scene.film.crop[0], scene.film.crop[3] - scene.film.crop[1],
            PassSet(), scene.film.exposure);
  film.set_splatting(kernel.splats);
  const Batch batch = BatchPlan(1, 1, 1, {.single_samples = kernel.single_samples})[0];
  std::unique_ptr<const Plan> plan;
  if (kernel.make_plan != nullptr) {
    plan = kernel.make_plan(render.context(), 1, render.stats);
    plan->nothing();
    plan->notes();
  }
  RenderContext context = render.context(plan.get());
  std::unique_ptr<LightPass> pass;
  if (kernel.make_light_pass != nullptr) {
    pass = kernel.make_light_pass(context, batch);
    for (int stage = 0; pass != nullptr && stage < pass->stages(); ++stage) {
      for (size_t job = 0; job < pass->jobs(stage); ++job) {
        pass->run(stage, job, context, render.stats);
      }
    }
  }
  context.light_pass = pass.get();
  for (size_t i = 0; i < film.tiles().size(); ++i) {
    TileBuffer buffer = film.buffer(i, 0, batch);
    kernel.render_tile(context, batch, film.tiles()[i], buffer, PassSet(), render.stats);
    film.merge(i, 0, std::move(buffer));
  }
  return render.stats.rays;
}

}  // namespace

void bind_cut_short_probes(nb::module_& m) {
  m.def("cut_short", &cut_short, nb::arg("scene"), nb::arg("settings"), nb::arg("seconds"));
}

}  // namespace vernier
