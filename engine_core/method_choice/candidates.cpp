#include "method_choice/candidates.h"

#include <array>

#include "bidirectional/technique_set.h"

namespace vernier {
namespace {

bool always(const Settings&, const Requirements&) { return true; }

bool starts_paths_at_lights(const Settings& settings, const Requirements& requirements) {
  Settings bidirectional = settings;
  bidirectional.integrator = static_cast<int>(IntegratorKind::kBdpt);
  return TechniqueSet(bidirectional, requirements).light_paths;
}

constexpr std::array kCandidates{
    Candidate{IntegratorKind::kPath, "path tracing", 1.0, always, false},
    Candidate{IntegratorKind::kBdpt, "bidirectional path tracing", 1.35, starts_paths_at_lights,
              true},
};

}  // namespace

std::span<const Candidate> candidates() { return kCandidates; }

}  // namespace vernier
