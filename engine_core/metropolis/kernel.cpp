#include "metropolis/kernel.h"

namespace vernier {

std::vector<std::string> describe_metropolis_limits(const Settings& settings,
                                                    const Requirements& requirements,
                                                    PassSet passes) {
  const auto kind = static_cast<IntegratorKind>(settings.integrator);
  const std::string name = kind == IntegratorKind::kPssmlt ? "Primary Sample Metropolis"
                           : kind == IntegratorKind::kMmlt ? "Multiplexed Metropolis"
                                                           : "Metropolis Light Transport";
  std::vector<std::string> notes;
  if (!TechniqueSet(settings, requirements).light_paths) {
    notes.push_back(name + " starts no paths at lights here: " +
                    (requirements.uneven_visibility
                         ? "some objects are visible to some kinds of scattered rays and hidden "
                           "from others"
                         : "bounces limited by kind are counted from the camera"));
  }
  for (const Pass pass :
       {Pass::kDiffuseIndirect, Pass::kGlossyIndirect, Pass::kTransmissionIndirect,
        Pass::kDiffuseDirect, Pass::kGlossyDirect, Pass::kTransmissionDirect}) {
    const bool direct = pass == Pass::kDiffuseDirect || pass == Pass::kGlossyDirect ||
                        pass == Pass::kTransmissionDirect;
    if (passes.has(pass) && !(direct && settings.separate_direct != 0)) {
      notes.push_back(name + " does not split the light of its chains into passes: " +
                      std::string(info(pass).name) + " lacks it");
    }
  }
  return notes;
}

}  // namespace vernier
