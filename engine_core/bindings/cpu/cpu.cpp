// What the processor can do, asked before any module for a certain instruction set is loaded.
#include <nanobind/nanobind.h>

#include <string>

#include <nanobind/stl/string.h>

namespace {

std::string best_level() {
#if defined(__x86_64__) && defined(__GNUC__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("x86-64-v4")) {
    return "v4";
  }
  if (__builtin_cpu_supports("x86-64-v3")) {
    return "v3";
  }
  if (__builtin_cpu_supports("x86-64-v2")) {
    return "v2";
  }
#endif
  return "";
}

}  // namespace

NB_MODULE(_cpu, m) {
  m.def("best_level", &best_level,
        "The highest x86-64 level of this processor: v4, v3, v2, or empty for none of them.");
}
