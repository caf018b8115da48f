#include "integrators/pssmlt.h"

#include "metropolis/kernel.h"
#include "metropolis/primary_explorer.h"

namespace vernier {

Kernel pssmlt_kernel(const Settings& settings, const Requirements& requirements, PassSet passes) {
  return metropolis_kernel<SampleExplorer>(settings, requirements, passes);
}

Kernel mmlt_kernel(const Settings& settings, const Requirements& requirements, PassSet passes) {
  return metropolis_kernel<TechniqueExplorer>(settings, requirements, passes);
}

}  // namespace vernier
