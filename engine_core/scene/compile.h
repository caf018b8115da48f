// From the description of a scene to the immutable Scene that is rendered.
#pragma once

#include <functional>
#include <memory>

#include "scene/description.h"
#include "scene/scene.h"

namespace vernier {

struct CompileOptions {
  int threads = 0;                  // 0: all there are
  bool keep_uv = false;             // keep active UV maps for the UV pass, read by materials or not
  std::function<bool()> cancelled;  // polled, by any thread; may be empty
  // Called once, when the description's meshes and images have been read: the rest of compilation
  // looks at them no more. May be empty.
  std::function<void()> large_parts_read;
  // For a scene that will change while it is looked at: its hierarchy is built sooner and traversed
  // slower, and what a later compilation needs to share parts of it is kept.
  bool interactive = false;
  // The scene before an edit, compiled interactively: what the description does not change is
  // shared with it. Geometry is one part: it is shared when all meshes (by identity), places, ray
  // masks and attributes are the same. Each material and image is one. Null: everything is made.
  std::shared_ptr<const Scene> previous;
};

// `description` has passed validation (engine_core.validation): indices and sizes are trusted.
// Throws std::invalid_argument naming what is wrong with a material's graph, std::runtime_error
// when Embree fails or the call is cancelled.
std::shared_ptr<const Scene> compile(const SceneDescription& description,
                                     const CompileOptions& options);

// The same scene through another camera onto another film; everything else is shared.
std::shared_ptr<const Scene> with_view(const std::shared_ptr<const Scene>& scene,
                                       const CameraDesc& camera, const FilmDesc& film);

}  // namespace vernier
