#include "render/priority.h"

#ifdef __linux__
#include <sys/resource.h>
#endif

namespace vernier {

void give_way() {
#ifdef __linux__
  // Niceness is a property of threads on Linux, 0 names the calling one; a tenth of the weight of
  // an ordinary thread. A refusal leaves the thread as it was.
  constexpr int kNiceness = 10;
  if (getpriority(PRIO_PROCESS, 0) < kNiceness) {
    setpriority(PRIO_PROCESS, 0, kNiceness);
  }
#endif
}

}  // namespace vernier
