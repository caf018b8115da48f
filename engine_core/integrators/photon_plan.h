// What photon methods find out about the scene before its first batch.
#pragma once

#include <string>
#include <vector>

#include "integrators/integrator.h"
#include "lights/emission_guide.h"
#include "photons/photon_pass.h"

namespace vernier {

struct PhotonPlan : Plan {
  EmissionGuide guide;          // of photons of all kinds
  EmissionGuide caustic_guide;  // of those that are to find specular surfaces
  PhotonOrder global, caustics;
  int global_map = -1, caustic_map = -1;  // their numbers among the orders; -1: there is none
  std::vector<std::string> shortages;     // what the maps lack

  std::vector<std::string> notes() const override { return shortages; }

  std::vector<PhotonOrder> orders() const {
    std::vector<PhotonOrder> result;
    if (global_map >= 0) {
      result.push_back(global);
    }
    if (caustic_map >= 0) {
      result.push_back(caustics);
    }
    return result;
  }
};

// Whether photons tell direct light as well.
inline bool photons_are_direct(const Settings& settings) {
  return static_cast<PhotonDirect>(settings.photon_direct) == PhotonDirect::kPhotons;
}

// The kinds of photons beside those that light sampling stands for, within the limits on bounces.
uint8_t indirect_kinds(const Settings& settings);

std::unique_ptr<const Plan> make_sppm_plan(const RenderContext& context, uint64_t seed,
                                           RenderStats& stats);
std::unique_ptr<const Plan> make_photon_map_plan(const RenderContext& context, uint64_t seed,
                                                 RenderStats& stats);

// What the user should know that photons leave out.
std::vector<std::string> describe_photon_limits(const Settings& settings,
                                                const Requirements& requirements);
// Which of the two maps the scene and the settings do without. What a pilot finds besides, the plan
// tells.
std::vector<std::string> describe_photon_maps(const Settings& settings,
                                              const Requirements& requirements);

}  // namespace vernier
