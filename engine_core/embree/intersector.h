// Ray casting against the scene's geometry. The only door to Embree.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "embree/library.h"
#include "math/transform.h"
#include "math/vec.h"

namespace vernier {

struct Mesh;
struct Instance;

// Points o + t d for t in [0, t_max]. d need not have unit length: a segment between two points
// is its difference with t_max 1.
struct Ray {
  Vec3f o;
  Vec3f d;
  float t_max = kInfinity;
};

// t is in units of the ray's direction.
struct Hit {
  float t = 0;
  float u = 0, v = 0;
  uint32_t instance = 0, triangle = 0;
};

// Bits of a ray mask beyond Visibility: shadow rays tell surfaces that may let light through
// from those that cannot.
enum RayMask : uint32_t {
  kMaskOpaqueShadow = 1u << 5,
  kMaskTransparentShadow = 1u << 6,
};

// Embree's view of the scene. Meshes of one instance lie in the top-level hierarchy in render
// space; meshes of several are hierarchies of their own that Embree instances refer to.
class Intersector {
 public:
  // `masks` gives the ray mask of each instance. The meshes' vertex and index arrays are shared
  // with Embree: they must outlive this object, unchanged. `fast_build`: hierarchies that are built
  // sooner and traversed slower. `cancelled` is polled while building.
  // Throws std::runtime_error when Embree reports an error (out of memory) or on cancellation.
  Intersector(std::span<const Mesh> meshes, std::span<const Instance> instances,
              std::span<const uint32_t> masks, int threads, bool fast_build,
              const std::function<bool()>& cancelled);
  ~Intersector();
  Intersector(const Intersector&) = delete;
  Intersector& operator=(const Intersector&) = delete;

  // The closest hit on an instance whose mask shares a bit with `mask`.
  bool intersect(const Ray& ray, uint32_t mask, Hit& hit) const {
    embree::RayHit r;
    r.org_x = ray.o.x, r.org_y = ray.o.y, r.org_z = ray.o.z, r.tnear = kBehind;
    r.dir_x = ray.d.x, r.dir_y = ray.d.y, r.dir_z = ray.d.z, r.time = 0.0f;
    r.tfar = ray.t_max, r.mask = mask, r.id = 0, r.flags = 0;
    r.geom_id = embree::kInvalidId, r.inst_id = embree::kInvalidId;
    intersect1_(top_, &r, nullptr);
    if (r.geom_id == embree::kInvalidId) {
      return false;
    }
    hit.t = r.tfar, hit.u = r.u, hit.v = r.v;
    hit.instance = r.inst_id != embree::kInvalidId ? r.inst_id : r.geom_id;
    hit.triangle = r.prim_id;
    return true;
  }

  // Whether anything that `mask` sees lies on the ray.
  bool occluded(const Ray& ray, uint32_t mask) const {
    embree::OcclusionRay r;
    r.org_x = ray.o.x, r.org_y = ray.o.y, r.org_z = ray.o.z, r.tnear = kBehind;
    r.dir_x = ray.d.x, r.dir_y = ray.d.y, r.dir_z = ray.d.z, r.time = 0.0f;
    r.tfar = ray.t_max, r.mask = mask, r.id = 0, r.flags = 0;
    occluded1_(top_, &r, nullptr);
    return r.tfar < 0.0f;
  }

 private:
  // A ray that starts exactly on a surface (a plane whose coordinate is 0 needs no offset) must not
  // meet it at t = 0, which Embree counts as a hit.
  static constexpr float kBehind = std::numeric_limits<float>::min();

  void release();

  const embree::Library& lib_;
  embree::Device device_ = nullptr;
  std::vector<embree::Scene> scenes_;  // of instanced meshes, and last the top one
  embree::Scene top_ = nullptr;
  void (*intersect1_)(embree::Scene, embree::RayHit*, void*) = nullptr;
  void (*occluded1_)(embree::Scene, embree::OcclusionRay*, void*) = nullptr;
};

}  // namespace vernier
