// A probe of which code has run, in builds for fuzzing (VERNIER_FUZZ): the compiler calls
// __sanitizer_cov_trace_pc at every edge of every function (-fsanitize-coverage=trace-pc).
#include "bindings/bind.h"

#if defined(VERNIER_FUZZ)
#include <cstddef>
#include <cstdint>

// What counts must not be counted, and so calls nothing that is: builtins and plain arrays only.
#define VERNIER_NOT_COUNTED __attribute__((no_sanitize_coverage))

namespace {

// How often each step from one place of the code to another was taken, as AFL counts them (M.
// Zalewski, "Technical details of AFL", 2014): counts of colliding steps are added, and counts go
// round at 256. Threads may lose each other's counts.
constexpr size_t kSteps = size_t{1} << 16;
uint8_t g_counts[kSteps];
// The magnitudes of counts that were ever seen, a bit for each.
uint8_t g_seen[kSteps];
thread_local uintptr_t t_previous = 0;

// 1, 2, 3, to 7, to 15, to 31, to 127, more.
VERNIER_NOT_COUNTED uint8_t magnitude(uint8_t count) {
  constexpr uint8_t kUpTo[] = {1, 2, 3, 7, 15, 31, 127};
  unsigned bit = 0;
  while (bit < sizeof(kUpTo) && count > kUpTo[bit]) {
    ++bit;
  }
  return static_cast<uint8_t>(1u << bit);
}

// Magnitudes that were not seen before; counting begins anew.
VERNIER_NOT_COUNTED size_t take_new_steps() {
  size_t found = 0;
  for (size_t i = 0; i < kSteps; ++i) {
    const uint8_t count = __atomic_exchange_n(&g_counts[i], uint8_t{0}, __ATOMIC_RELAXED);
    if (count != 0 && (g_seen[i] & magnitude(count)) == 0) {
      g_seen[i] |= magnitude(count);
      ++found;
    }
  }
  return found;
}

}  // namespace

extern "C" VERNIER_NOT_COUNTED void __sanitizer_cov_trace_pc() {
  // A multiplication spreads addresses over the table (Fibonacci hashing).
  const auto address = reinterpret_cast<uintptr_t>(__builtin_return_address(0));
  const uintptr_t place = address * uintptr_t{0x9e3779b97f4a7c15u} >> 48u;
  uint8_t* count = &g_counts[(place ^ t_previous) % kSteps];
  __atomic_store_n(count, static_cast<uint8_t>(__atomic_load_n(count, __ATOMIC_RELAXED) + 1u),
                   __ATOMIC_RELAXED);
  t_previous = place >> 1u;
}
#endif

namespace vernier {

void bind_coverage_probes([[maybe_unused]] nanobind::module_& m) {
#if defined(VERNIER_FUZZ)
  m.def("take_new_steps", &take_new_steps,
        "How many steps between places of the code, by their magnitude, have been taken since the "
        "last call and never before.");
#endif
}

}  // namespace vernier
