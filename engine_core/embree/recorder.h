// Records the rays of a render, and casts them again with nothing else: the yardstick of speed.
#pragma once

#include <cstddef>

namespace vernier::embree {

// From now on scenes are compiled so that their rays are kept, up to `capacity` in all; scenes
// compiled before are untouched. Rendering of a recorded scene is for one thread.
void start_recording(size_t capacity);

// Ends recording for scenes to come.
void stop_recording();

struct ReplayResult {
  size_t rays = 0;
  double seconds = 0;  // of casting them in their order on one thread
  size_t hits = 0;     // keeps the loop from being optimised away
};

// Casts the recorded rays again. The scene that they were recorded on must still exist.
ReplayResult replay();

}  // namespace vernier::embree
