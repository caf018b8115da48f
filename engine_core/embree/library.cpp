#include "embree/library.h"

#include <mutex>
#include <stdexcept>

#if defined(_WIN32)
#define WIN32_LEAN_AND_MEAN
#include <windows.h>
#else
#include <dlfcn.h>
#endif

namespace vernier::embree {
namespace {

Library g_library;
bool g_loaded = false;
std::mutex g_mutex;

#if defined(_WIN32)
void* open_library(const std::string& path, std::string& error) {
  HMODULE handle = LoadLibraryExA(path.c_str(), nullptr, LOAD_WITH_ALTERED_SEARCH_PATH);
  if (handle == nullptr) {
    error = "error " + std::to_string(GetLastError());
  }
  return reinterpret_cast<void*>(handle);
}
void* find_symbol(void* handle, const char* name) {
  return reinterpret_cast<void*>(GetProcAddress(reinterpret_cast<HMODULE>(handle), name));
}
#else
void* open_library(const std::string& path, std::string& error) {
  int flags = RTLD_NOW | RTLD_LOCAL;
#if defined(RTLD_DEEPBIND) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  flags |= RTLD_DEEPBIND;  // sanitizers replace malloc for the whole process and refuse it
#endif
  void* handle = dlopen(path.c_str(), flags);
  if (handle == nullptr) {
    const char* reason = dlerror();
    error = reason != nullptr ? reason : "unknown reason";
  }
  return handle;
}
void* find_symbol(void* handle, const char* name) { return dlsym(handle, name); }
#endif

template <typename Function>
void resolve(void* handle, const std::string& path, const char* name, Function& function) {
  void* symbol = find_symbol(handle, name);
  if (symbol == nullptr) {
    throw std::runtime_error("the Embree library " + path + " has no function " + name);
  }
  function = reinterpret_cast<Function>(symbol);
}

}  // namespace

void load(const std::string& path) {
  const std::lock_guard lock(g_mutex);
  if (g_loaded) {
    return;
  }
  std::string error;
  void* handle = open_library(path, error);
  if (handle == nullptr) {
    throw std::runtime_error("the Embree library " + path + " cannot be opened: " + error);
  }
  Library table;
#define VERNIER_RESOLVE(name, result, parameters) resolve(handle, path, #name, table.name);
  VERNIER_EMBREE_FUNCTIONS(VERNIER_RESOLVE)
#undef VERNIER_RESOLVE

  Device device = table.rtcNewDevice("threads=1,tessellation_cache_size=0");
  const ptrdiff_t version =
      device != nullptr ? table.rtcGetDeviceProperty(device, kPropertyVersion) : 0;
  if (device != nullptr) {
    table.rtcReleaseDevice(device);
  }
  // The layout of hits with instance primitive ids began with Embree 4.4.
  if (version < 40400 || version >= 50000) {
    throw std::runtime_error("the Embree library " + path + " has version number " +
                             std::to_string(version) + "; 4.4 or a later 4.x is needed");
  }
  g_library = table;
  g_loaded = true;
}

const Library& library() {
  if (!g_loaded) {
    throw std::runtime_error("the Embree library is not loaded");
  }
  return g_library;
}

void set_ray_functions(decltype(Library::rtcIntersect1) intersect,
                       decltype(Library::rtcOccluded1) occluded) {
  g_library.rtcIntersect1 = intersect;
  g_library.rtcOccluded1 = occluded;
}

}  // namespace vernier::embree
