#include "embree/intersector.h"

#include <array>
#include <cstdio>
#include <new>
#include <stdexcept>
#include <string>

#include "scene/scene.h"

namespace vernier {
namespace {

// Releases an Embree geometry when the scene that attached it holds its own reference.
struct GeometryGuard {
  const embree::Library& lib;
  embree::Geometry geometry;
  ~GeometryGuard() { lib.rtcReleaseGeometry(geometry); }
};

bool poll_progress(void* user, double /*fraction*/) {
  const auto* cancelled = static_cast<const std::function<bool()>*>(user);
  return !(*cancelled && (*cancelled)());
}

// The first error of a build. Embree tells of it from its own threads, where nothing may be thrown:
// so what is kept needs no memory.
struct BuildError {
  int code = embree::kErrorNone;
  std::array<char, 200> message{};

  void throw_if_any() const {
    if (code == embree::kErrorOutOfMemory) {
      throw std::bad_alloc();
    }
    if (code != embree::kErrorNone) {
      throw std::runtime_error("Embree error " + std::to_string(code) + ": " + message.data());
    }
  }
};

void remember_error(void* user, int code, const char* message) {
  auto* error = static_cast<BuildError*>(user);
  if (error->code == embree::kErrorNone) {
    error->code = code;
    std::snprintf(error->message.data(), error->message.size(), "%s",
                  message != nullptr ? message : "no message");
  }
}

}  // namespace

Intersector::Intersector(std::span<const Mesh> meshes, std::span<const Instance> instances,
                         std::span<const uint32_t> masks, int threads, bool fast_build,
                         const std::function<bool()>& cancelled)
    : lib_(embree::library()) {
  // No surface is subdivided here, so no cache of their triangles is needed: 128 MB by default, and
  // where there is no memory for it Embree keeps a lock for which the next device waits for ever.
  std::string config = "tessellation_cache_size=0";
  if (threads > 0) {
    config += ",threads=" + std::to_string(threads);
  }
  device_ = lib_.rtcNewDevice(config.c_str());
  if (device_ == nullptr) {
    throw std::bad_alloc();  // one was made when the library was loaded: the processor is able
  }
  BuildError error;
  lib_.rtcSetDeviceErrorFunction(device_, remember_error, &error);
  intersect1_ = lib_.rtcIntersect1;
  occluded1_ = lib_.rtcOccluded1;

  const auto new_scene = [&] {
    embree::Scene scene = lib_.rtcNewScene(device_);
    scenes_.push_back(scene);
    // Robust traversal: no ray slips between two triangles that share an edge.
    lib_.rtcSetSceneFlags(scene, embree::kSceneRobust);
    lib_.rtcSetSceneBuildQuality(scene, fast_build ? embree::kBuildMedium : embree::kBuildHigh);
    lib_.rtcSetSceneProgressMonitorFunction(scene, poll_progress,
                                            const_cast<std::function<bool()>*>(&cancelled));
    return scene;
  };
  const auto attach_triangles = [&](embree::Scene scene, const Mesh& mesh, uint32_t id,
                                    uint32_t mask) {
    const GeometryGuard g{lib_, lib_.rtcNewGeometry(device_, embree::kTriangles)};
    lib_.rtcSetSharedGeometryBuffer(g.geometry, embree::kVertexBuffer, 0, embree::kFloat3,
                                    mesh.positions.data(), 0, sizeof(Vec3f), mesh.positions.size());
    lib_.rtcSetSharedGeometryBuffer(g.geometry, embree::kIndexBuffer, 0, embree::kUint3,
                                    mesh.triangles.data(), 0, 3 * sizeof(uint32_t),
                                    mesh.triangles.size());
    lib_.rtcSetGeometryMask(g.geometry, mask);
    lib_.rtcCommitGeometry(g.geometry);
    lib_.rtcAttachGeometryByID(scene, g.geometry, id);
  };

  try {
    std::vector<embree::Scene> mesh_scenes(meshes.size(), nullptr);
    for (size_t i = 0; i < meshes.size(); ++i) {
      if (meshes[i].instanced && !meshes[i].triangles.empty()) {
        mesh_scenes[i] = new_scene();
        attach_triangles(mesh_scenes[i], meshes[i], 0, ~0u);
        lib_.rtcCommitScene(mesh_scenes[i]);
      }
    }
    top_ = new_scene();
    for (uint32_t i = 0; i < instances.size(); ++i) {
      const Instance& instance = instances[i];
      const Mesh& mesh = meshes[instance.mesh];
      if (mesh.triangles.empty()) {
        continue;
      }
      if (!mesh.instanced) {
        attach_triangles(top_, mesh, i, masks[i]);
        continue;
      }
      const GeometryGuard g{lib_, lib_.rtcNewGeometry(device_, embree::kInstance)};
      lib_.rtcSetGeometryInstancedScene(g.geometry, mesh_scenes[instance.mesh]);
      lib_.rtcSetGeometryTransform(g.geometry, 0, embree::kFloat3x4RowMajor,
                                   instance.to_render.m.data());
      lib_.rtcSetGeometryMask(g.geometry, masks[i]);
      lib_.rtcCommitGeometry(g.geometry);
      lib_.rtcAttachGeometryByID(top_, g.geometry, i);
    }
    lib_.rtcCommitScene(top_);
    for (embree::Scene scene : scenes_) {
      lib_.rtcSetSceneProgressMonitorFunction(scene, nullptr, nullptr);
    }
    lib_.rtcSetDeviceErrorFunction(device_, nullptr, nullptr);
    if (cancelled && cancelled()) {
      throw std::runtime_error("cancelled");
    }
    error.throw_if_any();
  } catch (...) {
    release();
    throw;
  }
}

Intersector::~Intersector() { release(); }

void Intersector::release() {
  for (embree::Scene scene : scenes_) {
    lib_.rtcReleaseScene(scene);
  }
  scenes_.clear();
  if (device_ != nullptr) {
    lib_.rtcReleaseDevice(device_);
    device_ = nullptr;
  }
}

}  // namespace vernier
