// `Auto`: which method renders a scene, by trying them.
//
// Each candidate renders the frame small, with few samples: together at most a twentieth of what
// the render itself will take. A picture's variance times its cost is what a method needs for any
// accuracy, so their ratio is how much longer one method takes than the other. Two things can
// deceive: light that a method did not meet at all, which shows where another's picture is brighter
// than both their errors allow, and light that none met, or few pixels did. So where the scene may
// have caustics and the pilot sees no clear difference, be it for most pixels, for the twentieth
// that a picture's error is told by, or for all, or there is too little time for one, a method that
// finds caustics renders. Chains (Metropolis light transport) render where they are clearly faster
// than all else: what a short trial says of them is less certain, and their errors are blotches.
// They also render where caustics may be, much of the light was met by single paths, and chains met
// much of it: then no pilot tells, and chains are guided to caustics.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>

#include "render/passes.h"
#include "render/settings.h"
#include "scene/scene.h"

namespace vernier {

struct MethodChoice {
  IntegratorKind integrator = IntegratorKind::kPath;
  std::string reason;  // a sentence; empty where the settings name a method
};

// The choice where there is nothing to try: the settings name a method, or only one fits, or the
// render is too short, or the first picture must come at once (`interactive`). Otherwise none.
std::optional<MethodChoice> choose_untried(const Scene& scene, const Settings& settings,
                                           PassSet passes, bool interactive);

// The choice by trying all that fit. Ends early, with any of them, once `cancelled` is set.
MethodChoice choose_by_trial(const std::shared_ptr<const Scene>& scene, const Settings& settings,
                             PassSet passes, const std::atomic<bool>& cancelled);

}  // namespace vernier
