// The part of Embree 4.4's C interface that Vernier uses, declared from its documented ABI
// (Embree 4 API reference; built with one instancing level, instance arrays and no minimum curve
// width, as the `embreex` wheels are). The library is opened at run time: see library.h.
#pragma once

#include <cstddef>
#include <cstdint>

namespace vernier::embree {

struct DeviceHandle;
struct SceneHandle;
struct GeometryHandle;
using Device = DeviceHandle*;
using Scene = SceneHandle*;
using Geometry = GeometryHandle*;

inline constexpr uint32_t kInvalidId = 0xffffffffu;

enum GeometryType : int { kTriangles = 0, kUser = 120, kInstance = 121 };
enum BufferType : int { kIndexBuffer = 0, kVertexBuffer = 1 };
enum Format : int { kUint3 = 0x5003, kFloat3 = 0x9003, kFloat3x4RowMajor = 0x9134 };
enum SceneFlags : int { kSceneNone = 0, kSceneDynamic = 1, kSceneCompact = 2, kSceneRobust = 4 };
enum BuildQuality : int { kBuildLow = 0, kBuildMedium = 1, kBuildHigh = 2 };
enum DeviceProperty : int { kPropertyVersion = 0 };
enum Error : int { kErrorNone = 0, kErrorOutOfMemory = 4 };

struct alignas(16) RayHit {
  float org_x, org_y, org_z, tnear;
  float dir_x, dir_y, dir_z, time;
  float tfar;
  uint32_t mask, id, flags;
  float ng_x, ng_y, ng_z;
  float u, v;
  uint32_t prim_id, geom_id, inst_id, inst_prim_id;
};
static_assert(sizeof(RayHit) == 96 && offsetof(RayHit, ng_x) == 48);

struct alignas(16) OcclusionRay {
  float org_x, org_y, org_z, tnear;
  float dir_x, dir_y, dir_z, time;
  float tfar;
  uint32_t mask, id, flags;
};
static_assert(sizeof(OcclusionRay) == 48);

struct alignas(16) Bounds {
  float lower_x, lower_y, lower_z, align0;
  float upper_x, upper_y, upper_z, align1;
};

using ErrorFunction = void (*)(void* user, int code, const char* message);
using ProgressFunction = bool (*)(void* user, double fraction);

// name, result, parameters of every function that is resolved from the library.
#define VERNIER_EMBREE_FUNCTIONS(X)                                                \
  X(rtcNewDevice, Device, (const char*))                                           \
  X(rtcReleaseDevice, void, (Device))                                              \
  X(rtcGetDeviceProperty, ptrdiff_t, (Device, DeviceProperty))                     \
  X(rtcGetDeviceError, int, (Device))                                              \
  X(rtcSetDeviceErrorFunction, void, (Device, ErrorFunction, void*))               \
  X(rtcNewScene, Scene, (Device))                                                  \
  X(rtcReleaseScene, void, (Scene))                                                \
  X(rtcSetSceneFlags, void, (Scene, SceneFlags))                                   \
  X(rtcSetSceneBuildQuality, void, (Scene, BuildQuality))                          \
  X(rtcSetSceneProgressMonitorFunction, void, (Scene, ProgressFunction, void*))    \
  X(rtcAttachGeometryByID, void, (Scene, Geometry, uint32_t))                      \
  X(rtcCommitScene, void, (Scene))                                                 \
  X(rtcNewGeometry, Geometry, (Device, GeometryType))                              \
  X(rtcReleaseGeometry, void, (Geometry))                                          \
  X(rtcCommitGeometry, void, (Geometry))                                           \
  X(rtcSetGeometryMask, void, (Geometry, uint32_t))                                \
  X(rtcSetGeometryInstancedScene, void, (Geometry, Scene))                         \
  X(rtcSetGeometryTransform, void, (Geometry, uint32_t, Format, const void*))      \
  X(rtcSetSharedGeometryBuffer, void,                                              \
    (Geometry, BufferType, uint32_t, Format, const void*, size_t, size_t, size_t)) \
  X(rtcIntersect1, void, (Scene, RayHit*, void*))                                  \
  X(rtcOccluded1, void, (Scene, OcclusionRay*, void*))

}  // namespace vernier::embree
