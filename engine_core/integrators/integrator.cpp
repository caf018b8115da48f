#include "integrators/integrator.h"

#include "integrators/bidirectional.h"
#include "integrators/path.h"
#include "integrators/whitted.h"

namespace vernier {

Kernel choose_kernel(const Settings& settings, const Requirements& requirements, PassSet passes) {
  switch (static_cast<IntegratorKind>(settings.integrator)) {
    case IntegratorKind::kPath:
      break;
    case IntegratorKind::kWhitted:
      return {whitted_kernel()};
    case IntegratorKind::kLight:
    case IntegratorKind::kBdpt:
      return bidirectional_kernel(settings, requirements, passes);
  }
  return {path_kernel(settings, requirements, passes)};
}

}  // namespace vernier
