#include "integrators/integrator.h"

#include "integrators/path.h"
#include "integrators/whitted.h"

namespace vernier {

RenderTile choose_kernel(const Settings& settings, const Requirements& requirements,
                         PassSet passes) {
  switch (static_cast<IntegratorKind>(settings.integrator)) {
    case IntegratorKind::kPath:
      return path_kernel(settings, requirements, passes);
    case IntegratorKind::kWhitted:
      return whitted_kernel();
  }
  return path_kernel(settings, requirements, passes);
}

}  // namespace vernier
