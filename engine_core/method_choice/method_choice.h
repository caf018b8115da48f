// `Auto`: which method renders a scene, by trying them.
//
// Each candidate renders the frame small, with few samples: together at most a twentieth of what
// the render itself will take. A picture's variance times its cost is what a method needs for any
// accuracy, so their ratio is how much longer one method takes than the other. Two things can
// deceive: light that a method did not meet at all, which shows where another's picture is brighter
// than both their errors allow, and light that none met. So where the scene may have caustics and
// the pilot sees no clear difference, or there is too little time for one, a method that finds
// caustics renders.
#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "render/settings.h"
#include "scene/scene.h"

namespace vernier {

struct MethodChoice {
  Settings settings;   // those given, with the method chosen
  std::string reason;  // a sentence; empty where the settings name a method
  double seconds = 0;  // that it took
};

// `settings.integrator` may be any: only Auto is decided upon. `interactive`: the first picture
// must come at once, so nothing is tried. `cancelled` ends it early, with path tracing; may be
// null.
MethodChoice choose_method(const std::shared_ptr<const Scene>& scene, const Settings& settings,
                           bool interactive, const std::atomic<bool>* cancelled = nullptr);

}  // namespace vernier
