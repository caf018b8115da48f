// What every integrator is to the render session: a function that renders one tile of one batch.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "render/batch_plan.h"
#include "render/film.h"
#include "render/settings.h"
#include "sampling/pixel_filter.h"
#include "scene/scene.h"

namespace vernier {

// What a thread has done. Padded, so that threads do not share cache lines.
struct alignas(64) RenderStats {
  uint64_t rays = 0;
  uint64_t camera_paths = 0;
  uint64_t non_finite = 0;  // samples that were dropped because they were not finite
};

// What a method finds out about the scene before its first batch. The same for equal seeds.
struct Plan {
  virtual ~Plan() = default;
  // Empty, or why there is nothing to find: a sentence. The render then ends after two batches.
  virtual std::string nothing() const { return {}; }
  // What the user should know of what was found, or not: a sentence each.
  virtual std::vector<std::string> notes() const { return {}; }
};

struct LightPass;

struct RenderContext {
  const Scene& scene;
  const Settings& settings;
  const PixelFilter2d& filter;
  const std::atomic<bool>& cancelled;     // by the user, or because the time is up
  const Plan* plan = nullptr;             // the method's own
  const LightPass* light_pass = nullptr;  // of the batch, where the method has one
};

// What the light's sub-paths of one batch leave for all of its tiles: photons, or vertices, and
// their index. Threads make it together, stage by stage: a stage begins when all jobs of the one
// before are done, the batch's tiles when those of the last are. What comes out must depend on the
// jobs' numbers alone, never on who did them or when.
struct LightPass {
  virtual ~LightPass() = default;
  virtual int stages() const = 0;
  // The number of jobs of a stage; asked for when the stages before are done.
  virtual size_t jobs(int stage) const = 0;
  // Does one of them; returns early once the render is cancelled. It may throw: the render ends.
  virtual void run(int stage, size_t job, const RenderContext& context, RenderStats& stats) = 0;
};

// Renders `batch` for the pixels of `tile` (film coordinates) into `buffer`. Returns early, with
// what it has, once the render is cancelled or its time is up.
using RenderTile = void (*)(const RenderContext& context, const Batch& batch, const Tile& tile,
                            TileBuffer& buffer, PassSet passes, RenderStats& stats);

struct Kernel {
  RenderTile render_tile = nullptr;
  bool splats = false;  // samples add to pixels other than their own
  // Makes the plan; null where the method needs none.
  std::unique_ptr<const Plan> (*make_plan)(const RenderContext& context, uint64_t seed,
                                           RenderStats& stats) = nullptr;
  // Begins a batch's light pass, or returns null where it turns out to need none; null where the
  // method has none. `context` has the plan.
  std::unique_ptr<LightPass> (*make_light_pass)(const RenderContext& context,
                                                const Batch& batch) = nullptr;
  bool single_samples = false;          // batches do not grow: each is one sample per pixel
  std::vector<std::string> notes = {};  // what the method leaves out in this scene, a sentence each
};

// The kernel of the chosen integrator for what this scene and these passes need, and nothing else.
Kernel choose_kernel(const Settings& settings, const Requirements& requirements, PassSet passes);

}  // namespace vernier
