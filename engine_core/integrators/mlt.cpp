#include "integrators/mlt.h"

#include "metropolis/kernel.h"
#include "metropolis/path_explorer.h"

namespace vernier {

Kernel mlt_kernel(const Settings& settings, const Requirements& requirements, PassSet passes) {
  // What a path as a value does not tell: how its walks came to its surfaces, and what their rays
  // were to what they met.
  std::string why;
  if (requirements.path_dependent) {
    why = "some materials read what the path has been through";
  } else if (requirements.hidden_from_rays || requirements.uneven_visibility) {
    why = "some objects are hidden from some kinds of rays";
  } else if (BounceLimits::by_kind(settings)) {
    why = "bounces are limited by kind";
  } else if (requirements.transparent_shadows && settings.transparent_bounces >= 0) {
    why = "the number of surfaces that light passes straight through is limited";
  }
  if (why.empty()) {
    Kernel kernel = metropolis_kernel<PathExplorer>(settings, requirements, passes);
    const bool direct = settings.separate_direct == 0 && settings.clamp_direct > 0.0;
    if (direct || settings.clamp_indirect > 0.0) {
      kernel.notes.push_back(
          std::string("Metropolis Light Transport does not clamp the light of its chains: ") +
          (direct && settings.clamp_indirect > 0.0 ? "Clamp Direct and Clamp Indirect have"
           : direct                                ? "Clamp Direct has"
                                                   : "Clamp Indirect has") +
          " no effect on it");
    }
    return kernel;
  }
  Kernel kernel = metropolis_kernel<TechniqueExplorer>(settings, requirements, passes);
  kernel.notes.insert(
      kernel.notes.begin(),
      "Metropolis Light Transport changes the numbers that paths are made from here, "
      "as Multiplexed Metropolis does: " +
          why);
  return kernel;
}

}  // namespace vernier
