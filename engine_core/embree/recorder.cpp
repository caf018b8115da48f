#include "embree/recorder.h"

#include <chrono>
#include <vector>

#include "embree/library.h"
#include "math/float_environment.h"

namespace vernier::embree {
namespace {

struct RecordedRay {
  OcclusionRay ray;
  Scene scene;
  bool occlusion;
};

std::vector<RecordedRay> g_rays;
size_t g_capacity = 0;
Library g_plain;

void keep(Scene scene, const OcclusionRay& ray, bool occlusion) {
  if (g_rays.size() < g_capacity) {
    g_rays.push_back({ray, scene, occlusion});
  }
}

void recording_intersect(Scene scene, RayHit* r, void* arguments) {
  keep(scene,
       {r->org_x, r->org_y, r->org_z, r->tnear, r->dir_x, r->dir_y, r->dir_z, r->time, r->tfar,
        r->mask, r->id, r->flags},
       false);
  g_plain.rtcIntersect1(scene, r, arguments);
}

void recording_occluded(Scene scene, OcclusionRay* r, void* arguments) {
  keep(scene, *r, true);
  g_plain.rtcOccluded1(scene, r, arguments);
}

}  // namespace

void start_recording(size_t capacity) {
  if (g_plain.rtcIntersect1 == nullptr) {
    g_plain = library();
  }
  g_rays.clear();
  g_rays.reserve(capacity);
  g_capacity = capacity;
  set_ray_functions(recording_intersect, recording_occluded);
}

void stop_recording() {
  if (g_plain.rtcIntersect1 != nullptr) {
    set_ray_functions(g_plain.rtcIntersect1, g_plain.rtcOccluded1);
  }
}

ReplayResult replay() {
  const FlushDenormals flush;
  ReplayResult result;
  const auto start = std::chrono::steady_clock::now();
  for (const RecordedRay& recorded : g_rays) {
    if (recorded.occlusion) {
      OcclusionRay ray = recorded.ray;
      g_plain.rtcOccluded1(recorded.scene, &ray, nullptr);
      result.hits += ray.tfar < 0.0f ? 1 : 0;
      continue;
    }
    const OcclusionRay& r = recorded.ray;
    RayHit ray;
    ray.org_x = r.org_x, ray.org_y = r.org_y, ray.org_z = r.org_z, ray.tnear = r.tnear;
    ray.dir_x = r.dir_x, ray.dir_y = r.dir_y, ray.dir_z = r.dir_z, ray.time = r.time;
    ray.tfar = r.tfar, ray.mask = r.mask, ray.id = r.id, ray.flags = r.flags;
    ray.geom_id = kInvalidId, ray.inst_id = kInvalidId;
    g_plain.rtcIntersect1(recorded.scene, &ray, nullptr);
    result.hits += ray.geom_id != kInvalidId ? 1 : 0;
  }
  result.rays = g_rays.size();
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace vernier::embree
