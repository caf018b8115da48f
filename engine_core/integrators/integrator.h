// What every integrator is to the render session: a function that renders one tile of one batch.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "render/film.h"
#include "render/settings.h"
#include "sampling/pixel_filter.h"
#include "scene/scene.h"

namespace vernier {

// A batch is a pass over the whole frame: samples `first` to `first + samples` of every pixel, of
// the 2^log2_capacity that the render's sequence has room for.
struct Batch {
  uint64_t seed = 0;
  uint32_t first = 0;
  uint32_t samples = 1;
  int log2_capacity = 0;
};

// What a thread has done. Padded, so that threads do not share cache lines.
struct alignas(64) RenderStats {
  uint64_t rays = 0;
  uint64_t camera_paths = 0;
  uint64_t non_finite = 0;  // samples that were dropped because they were not finite
};

// What a method finds out about the scene before its first batch. The same for equal seeds.
struct Plan {
  virtual ~Plan() = default;
};

struct RenderContext {
  const Scene& scene;
  const Settings& settings;
  const PixelFilter2d& filter;
  const std::atomic<bool>& cancelled;  // by the user, or because the time is up
  const Plan* plan = nullptr;          // the method's own
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
  std::vector<std::string> notes = {};  // what the method leaves out in this scene, a sentence each
};

// The kernel of the chosen integrator for what this scene and these passes need, and nothing else.
Kernel choose_kernel(const Settings& settings, const Requirements& requirements, PassSet passes);

}  // namespace vernier
