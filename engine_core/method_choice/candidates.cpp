#include "method_choice/candidates.h"

#include <array>

#include "bidirectional/technique_set.h"
#include "integrators/integrator.h"

namespace vernier {
namespace {

bool always(const Settings&, const Requirements&, PassSet) { return true; }

bool starts_paths_at_lights(const Settings& settings, const Requirements& requirements, PassSet) {
  Settings bidirectional = settings;
  bidirectional.integrator = static_cast<int>(IntegratorKind::kBdpt);
  return TechniqueSet(bidirectional, requirements).light_paths;
}

bool chains_show_everything(const Settings& settings, const Requirements& requirements,
                            PassSet passes) {
  Settings metropolis = settings;
  metropolis.integrator = static_cast<int>(IntegratorKind::kMlt);
  return choose_kernel(metropolis, requirements, passes).notes.empty();
}

constexpr std::array kCandidates{
    Candidate{IntegratorKind::kPath, "path tracing", 1.0, always, false, false},
    Candidate{IntegratorKind::kBdpt, "bidirectional path tracing", 1.35, starts_paths_at_lights,
              true, false},
    Candidate{IntegratorKind::kMlt, "Metropolis light transport", 1.35, chains_show_everything,
              true, true},
};

}  // namespace

std::span<const Candidate> candidates() { return kCandidates; }

}  // namespace vernier
