#include "integrators/integrator.h"

#include "integrators/bidirectional.h"
#include "integrators/mlt.h"
#include "integrators/path.h"
#include "integrators/photon_map_integrator.h"
#include "integrators/pssmlt.h"
#include "integrators/sppm.h"
#include "integrators/whitted.h"

namespace vernier {

Kernel choose_kernel(const Settings& settings, const Requirements& requirements, PassSet passes) {
  switch (static_cast<IntegratorKind>(settings.integrator)) {
    case IntegratorKind::kPath:
    case IntegratorKind::kAuto:  // decided upon before (pilot/method_choice.h)
      break;
    case IntegratorKind::kWhitted:
      return {.render_tile = whitted_kernel()};
    case IntegratorKind::kLight:
    case IntegratorKind::kBdpt:
    case IntegratorKind::kVcm:
      return bidirectional_kernel(settings, requirements, passes);
    case IntegratorKind::kPssmlt:
      return pssmlt_kernel(settings, requirements, passes);
    case IntegratorKind::kMmlt:
      return mmlt_kernel(settings, requirements, passes);
    case IntegratorKind::kPhoton:
      return photon_map_kernel(settings, requirements, passes);
    case IntegratorKind::kSppm:
      return sppm_kernel(settings, requirements, passes);
    case IntegratorKind::kMlt:
      return mlt_kernel(settings, requirements, passes);
  }
  return {.render_tile = path_kernel(settings, requirements, passes)};
}

}  // namespace vernier
