// The methods that `Auto` chooses from.
#pragma once

#include <span>
#include <string_view>

#include "render/passes.h"
#include "render/settings.h"
#include "scene/requirements.h"

namespace vernier {

// A method without bias, whose stated error therefore is all of its error.
struct Candidate {
  IntegratorKind kind;
  std::string_view name;  // within a sentence
  // Time of a ray with all that is done around it, relative to path tracing's: measured over the
  // shipped scenes. Rays times this are a method's cost, whatever else the machine is busy with.
  double cost_per_ray;
  // Whether the method differs from path tracing in a scene with these requirements, and leaves
  // nothing out.
  bool (*fits)(const Settings& settings, const Requirements& requirements, PassSet passes);
  // Finds light that passed mirrors or glass on its way to a matte surface.
  bool finds_caustics;
  // Explores by chains: errors of pixels are alike over some distance, and a trial may well have
  // missed what chains stay at.
  bool chains;
};

// Path tracing comes first: it can render anything.
std::span<const Candidate> candidates();

}  // namespace vernier
