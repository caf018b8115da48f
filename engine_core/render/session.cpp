#include "render/session.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <stdexcept>

#include "math/float_environment.h"
#include "math/memory_message.h"
#include "math/parallel.h"
#include "math/rng.h"
#include "render/priority.h"

namespace vernier {
namespace {

// A frame of splats counts as a whole or not at all: when the time is up, little must be lost.
constexpr uint32_t kSplattingShare = 16, kTileShare = 4;

constexpr uint32_t kMostPlanned = 1u << 16, kPlannedWithoutEnd = 1u << 12;

// Looks at the error of the picture: the first, and how much samples grow from one to the next.
constexpr uint32_t kFirstLook = 16;
constexpr double kLookGrowth = 1.125;

uint32_t planned_for(const Settings& settings) {
  const auto samples = static_cast<uint32_t>(settings.samples);
  // A render that has no end in sight does not plan for it: its nets would never be full.
  return samples <= kMostPlanned ? samples : kPlannedWithoutEnd;
}

// All settings that a picture depends on, but for how long it is rendered.
std::string picture_settings(const Settings& settings) {
  std::string text;
  for (const Parameter& p : parameters()) {
    const bool limit = p.name == "samples" || p.name == "time_limit" || p.name == "target_error" ||
                       p.name == "adaptive" || p.name == "threads";
    if (!limit && !p.of_film()) {
      const double value = p.integer != nullptr ? settings.*(p.integer) : settings.*(p.real);
      text += std::string(p.name) + "=" + std::to_string(value) + " ";
    }
  }
  return text;
}

BatchPlan plan_for(const Settings& settings, const Kernel& kernel, uint32_t planned) {
  return {hash64(static_cast<uint64_t>(settings.seed)),
          static_cast<uint32_t>(settings.samples),
          planned,
          {.share = kernel.splats ? kSplattingShare : kTileShare,
           .single_samples = kernel.single_samples}};
}

}  // namespace

Session::Method::Method(Kernel&& chosen, const Settings& settings, const Session& session)
    : kernel(std::move(chosen)),
      plan(plan_for(settings, kernel, session.planned_samples_)),
      light_passes(kernel, plan, session.film_.batches()) {}

Session::Session(std::shared_ptr<const Scene> scene, const Settings& settings, PassSet passes,
                 bool give_way, const Resumption& resumption)
    : scene_(std::move(scene)),
      state_(resumption.path.empty() ? nullptr : std::make_unique<StateReader>(resumption.path)),
      planned_samples_(planned_for(settings)),
      settings_(resumed(settings, resumption.scene)),
      passes_(passes),
      film_(scene_->film.crop[2] - scene_->film.crop[0],
            scene_->film.crop[3] - scene_->film.crop[1], passes, scene_->film.exposure),
      filter_(scene_->film.filter, scene_->film.filter_width),
      thread_count_(resolve_threads(settings_.threads)),
      give_way_(give_way),
      stats_(static_cast<size_t>(thread_count_)),
      rays_(static_cast<size_t>(thread_count_)) {
  if (std::optional<MethodChoice> choice = choose_untried(*scene_, settings_, passes_, give_way)) {
    settle(std::move(*choice));
  }
  schedule_ = std::make_unique<Schedule>(film_.batches(), [this] { return look(); });
  changed_.assign(film_.tiles().size(), false);
  constexpr size_t kLongMessage = 256;
  error_message_.reserve(kLongMessage);  // there may be no memory left to tell that there is none
}

void Session::settle(MethodChoice&& choice) {
  Settings settings = settings_;
  settings.integrator = static_cast<int>(choice.integrator);
  Kernel kernel = choose_kernel(settings, scene_->requirements, passes_);
  film_.set_splatting(kernel.splats);
  if (state_ != nullptr) {
    film_.load(*state_);
    state_.reset();
  }
  auto method = std::make_unique<Method>(std::move(kernel), settings, *this);
  const std::lock_guard lock(mutex_);
  settings_.integrator = settings.integrator;
  choice_ = std::move(choice.reason);
  method_ = std::move(method);
}

// Not by std::call_once: an exception from there passes frames of the C library, which are unwound
// by the system's runtime, and that ends the process when it is of a module's own runtime.
void Session::prepare(const RenderContext& context, RenderStats& stats) {
  const std::lock_guard preparing(preparing_);
  if (prepared_) {
    return;
  }
  if (method_ == nullptr) {
    MethodChoice choice = choose_by_trial(scene_, settings_, passes_, stopped_);
    if (stopped_) {
      prepared_ = true;
      return;
    }
    settle(std::move(choice));
  }
  if (method_->kernel.make_plan != nullptr) {
    plan_of_method_ = method_->kernel.make_plan(context, method_->plan[0].seed, stats);
    heed(*plan_of_method_);
  }
  prepared_ = true;
}

std::string Session::choice() const {
  const std::lock_guard lock(mutex_);
  return choice_;
}

IntegratorKind Session::integrator() const {
  const std::lock_guard lock(mutex_);
  return static_cast<IntegratorKind>(settings_.integrator);
}

Settings Session::resumed(const Settings& given, const std::string& scene) {
  Settings settings = given;
  if (state_ == nullptr) {
    return settings;
  }
  std::string saved_scene, saved_settings;
  int integrator = 0;
  state_->get(saved_scene);
  state_->get(integrator);
  state_->get(saved_settings);
  state_->get(planned_samples_);
  state_->get(looks_);
  if (static_cast<IntegratorKind>(settings.integrator) == IntegratorKind::kAuto) {
    settings.integrator = integrator;
  }
  if (saved_scene != scene) {
    state_->refuse("is of another scene");
  }
  if (saved_settings != picture_settings(settings)) {
    state_->refuse("is of a render with other settings");
  }
  if (static_cast<IntegratorKind>(integrator) == IntegratorKind::kAuto) {
    state_.reset();  // it was still trying methods: there is no picture to go on with
  }
  return settings;
}

void Session::save(const std::string& path, const std::string& scene) const {
  StateWriter state;
  state.add(scene);
  {
    const std::lock_guard lock(mutex_);
    state.add(settings_.integrator);
    state.add(picture_settings(settings_));
  }
  state.add(planned_samples_);
  state.add(looks_);
  film_.save(state);
  state.write(path);
}

Session::~Session() {
  cancel();
  for (std::thread& thread : threads_) {
    thread.join();
  }
  if (watch_.joinable()) {
    watch_.join();
  }
}

void Session::start() {
  if (started_) {
    throw std::logic_error("a session renders once");
  }
  start_ = Clock::now();
  started_ = true;
  running_ = thread_count_;
  if (settings_.time_limit > 0.0) {
    try {
      watch_ = std::thread([this] { watch_the_time(); });
    } catch (const std::exception&) {
      thread_ended(thread_count_);
      throw;
    }
  }
  for (int i = 0; i < thread_count_; ++i) {
    try {
      threads_.emplace_back([this, i] { work(i); });
    } catch (const std::exception&) {
      // The system has no more threads to give, or no memory: those that there are do the work.
      thread_ended(thread_count_ - i);
      thread_count_ = i;
      if (i == 0) {
        throw;
      }
    }
  }
}

void Session::cancel() {
  cancelled_ = true;
  stop(Ending::kCancelled);
}

void Session::stop(Ending ending) {
  Ending none = Ending::kNone;
  ending_.compare_exchange_strong(none, ending);
  stopped_ = true;
  schedule_->end();
}

void Session::watch_the_time() {
  if (!wait(settings_.time_limit)) {
    stop(Ending::kTime);
  }
}

Schedule::Round Session::look() {
  const uint64_t begun = film_.least_batches();
  Ending ending = Ending::kNone;
  if (begun >= method_->plan.size()) {
    ending = Ending::kSamples;
  }
  Film::Look found;
  if (settings_.target_error > 0.0 && begun > 0) {
    found = film_.look(++looks_);
    if (meets(found.certificate, 0.01 * settings_.target_error)) {
      ending = Ending::kTarget;
    }
  }
  const std::vector<uint64_t> before = film_.batches();
  std::vector<uint64_t> round = before;
  const bool adapts = settings_.adaptive != 0 && settings_.target_error > 0.0 && begun > 0 &&
                      !method_->kernel.splats && method_->kernel.make_light_pass == nullptr;
  std::vector<bool> active(round.size(), true);
  if (adapts) {
    active = film_.unfinished(found.errors, 0.01 * settings_.target_error);
    // A tile that stopped before would keep the picture from being certified, and others going.
    for (size_t tile = 0; tile < active.size(); ++tile) {
      active[tile] = active[tile] || before[tile] < kLeastBatches;
    }
    // Where the pixels are well but the picture's mean is not, all tiles are in need.
    if (std::find(active.begin(), active.end(), true) == active.end()) {
      active.assign(active.size(), true);
    }
  }
  for (size_t tile = 0; tile < round.size(); ++tile) {
    round[tile] = active[tile] ? next_look(round[tile]) : round[tile];
  }
  if (ending == Ending::kNone && round == before) {
    ending = Ending::kSamples;  // where the target is not met there are none left
  }
  if (ending != Ending::kNone) {
    Ending none = Ending::kNone;
    ending_.compare_exchange_strong(none, ending);
    return {};
  }
  return round;
}

uint64_t Session::next_look(uint64_t begun) const {
  if (begun >= method_->plan.size()) {  // a state may have more samples than are asked for now
    return begun;
  }
  if (settings_.target_error == 0.0) {
    return method_->plan.size();
  }
  const double samples = std::max<double>(kFirstLook, kLookGrowth * method_->plan[begun].first);
  uint64_t until = begun + 1;
  while (until < method_->plan.size() && method_->plan[until].first < samples) {
    ++until;
  }
  return until;
}

double Session::elapsed() const {
  if (!started_) {
    return 0.0;
  }
  const int64_t end = end_nanoseconds_;
  if (end >= 0) {
    return static_cast<double>(end) * 1e-9;
  }
  return std::chrono::duration<double>(Clock::now() - start_).count();
}

void Session::heed(const Plan& plan) {
  if (stopped_) {
    return;
  }
  std::vector<std::string> notes = plan.notes();
  if (std::string nothing = plan.nothing(); !nothing.empty()) {
    constexpr uint64_t kForErrors = 2;
    method_->plan.shorten(std::min<uint64_t>(
        method_->plan.size(), std::max<uint64_t>(film_.least_batches(), kForErrors)));
    notes.push_back(std::move(nothing));
  }
  const std::lock_guard lock(mutex_);
  late_notes_.insert(late_notes_.end(), notes.begin(), notes.end());
}

std::vector<std::string> Session::notes() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> all;
  if (method_ != nullptr) {
    all = method_->kernel.notes;
  }
  all.insert(all.end(), late_notes_.begin(), late_notes_.end());
  return all;
}

void Session::work(int thread) {
  if (give_way_) {
    vernier::give_way();
  }
  const FlushDenormals flush;
  RenderContext context{*scene_, settings_, filter_, stopped_};
  RenderStats& stats = stats_[static_cast<size_t>(thread)];
  try {
    prepare(context, stats);
    context.plan = plan_of_method_.get();
    Job job;
    while (method_ != nullptr && schedule_->next(job)) {
      const auto [tile_number, number] = job;
      const Tile& tile = film_.tiles()[tile_number];
      const Batch batch = method_->plan[number];
      std::shared_ptr<const LightPass> light_pass;
      if (method_->kernel.make_light_pass != nullptr &&
          !method_->light_passes.get(context, number, stats, light_pass)) {
        break;
      }
      RenderContext tile_context = context;
      tile_context.light_pass = light_pass.get();
      TileBuffer buffer = film_.buffer(tile_number, number, batch);
      method_->kernel.render_tile(tile_context, batch, tile, buffer, film_.passes(), stats);
      if (stopped_) {
        break;  // pixels of an unfinished tile would have a batch of another size
      }
      const Film::Merged merged = film_.merge(tile_number, number, std::move(buffer));
      schedule_->done();
      rays_[static_cast<size_t>(thread)] = stats.rays;
      const std::lock_guard lock(mutex_);
      if (merged == Film::Merged::kTile) {
        changed_[tile_number] = true;
      } else if (merged == Film::Merged::kFrame) {
        changed_.assign(changed_.size(), true);
      }
    }
  } catch (const std::exception& e) {
    stop(Ending::kFailed);
    const std::lock_guard lock(mutex_);
    error_message_ = message_of(e);
  }
  non_finite_ += stats.non_finite;
  thread_ended(1);
}

void Session::tell_what_is_empty() noexcept {
  if (ending_ != Ending::kTime || film_.least_batches() > 0) {
    return;
  }
  try {
    late_notes_.emplace_back(
        film_.pixel_samples() == 0
            ? "The time limit ended the render before its first pass was done: the picture is empty"
            : "The time limit ended the render before every pixel had a sample: those that have "
              "none are empty");
  } catch (const std::bad_alloc&) {
    // There is no memory left for a sentence.
  }
}

void Session::thread_ended(int count) {
  const std::lock_guard lock(mutex_);
  running_ -= count;
  if (running_ == 0) {
    tell_what_is_empty();
    end_nanoseconds_ =
        std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now() - start_).count();
    finished_.notify_all();
  }
}

bool Session::wait(double seconds) {
  std::unique_lock lock(mutex_);
  // The clock counts nanoseconds in 64 bits: some decades are as good as for ever.
  constexpr double kLongest = 1e9;
  const std::chrono::duration<double> longest(std::min(std::max(0.0, seconds), kLongest));
  return finished_.wait_for(lock, longest, [this] { return running_ == 0; });
}

Progress Session::poll(bool with_error) const {
  Progress p;
  p.done = started_ && running_ == 0;  // first: then the rest is final too
  const double pixels = static_cast<double>(film_.width()) * static_cast<double>(film_.height());
  p.samples = static_cast<double>(film_.pixel_samples()) / pixels;
  p.samples_target = settings_.samples;
  p.seconds = elapsed();
  for (const auto& rays : rays_) {
    p.rays += rays;
  }
  p.non_finite = non_finite_;
  p.cancelled = cancelled_;
  p.ending = p.done ? ending_.load() : Ending::kNone;
  p.error = with_error ? film_.error() : static_cast<double>(kInfinity);
  double left = p.samples > 0.0 ? p.seconds * (p.samples_target / p.samples - 1.0)
                                : static_cast<double>(kInfinity);
  if (settings_.time_limit > 0.0) {
    left = std::min(left, settings_.time_limit - p.seconds);
  }
  if (settings_.target_error > 0.0 && std::isfinite(p.error)) {
    // An error falls with the root of the samples.
    const double ratio = p.error / (0.01 * settings_.target_error);
    left = std::min(left, p.seconds * (ratio * ratio - 1.0));
  }
  p.seconds_left = p.done ? 0.0 : std::max(left, 0.0);
  return p;
}

std::vector<Tile> Session::take_tiles() {
  std::vector<Tile> tiles;
  const std::lock_guard lock(mutex_);
  for (size_t i = 0; i < changed_.size(); ++i) {
    if (changed_[i]) {
      tiles.push_back(film_.tiles()[i]);
      changed_[i] = false;
    }
  }
  return tiles;
}

std::string Session::error_message() const {
  const std::lock_guard lock(mutex_);
  return error_message_;
}

}  // namespace vernier
