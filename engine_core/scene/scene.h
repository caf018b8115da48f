// The compiled scene: immutable while it is rendered, shared by all threads.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "embree/intersector.h"
#include "math/transform.h"
#include "math/vec.h"
#include "scene/description.h"
#include "scene/requirements.h"
#include "scene/surface_point.h"

namespace vernier {

class Camera;
class LightSampler;
class Material;
class ImageTexture;
struct Geometry;
struct SceneSource;

// What was made for a scene, as opposed to shared with the one before it.
struct CompiledParts {
  bool geometry = false;
  bool lights = false;
  uint32_t materials = 0;
  uint32_t images = 0;
  bool changed = true;  // a picture of it may differ from one of the scene before
};

// Values of one attribute of one mesh, on its elements.
struct MeshAttribute {
  Domain domain = Domain::kPoint;
  int channels = 0;  // 0: the mesh does not carry this attribute
  std::vector<float> data;
};

// Triangles and what materials read on them. Arrays that nothing needs stay empty.
struct Mesh {
  std::string name;
  std::vector<Vec3f> positions;                    // instanced: object space; else render space
  std::vector<std::array<uint32_t, 3>> triangles;  // vertices
  std::vector<std::array<uint32_t, 3>> corners;    // corners of the polygons
  std::vector<uint32_t> faces;                     // polygon of each triangle
  std::vector<uint16_t> slots;                     // material slot of each triangle; empty: 0
  Domain normal_domain = Domain::kFace;
  std::vector<Vec3f> normals;                  // in the space of positions
  std::vector<MeshAttribute> attributes;       // by attribute id (Scene::attribute_names)
  Vec3f texture_space_min, texture_space_max;  // object space
  Transform to_object;                         // positions to object space
  bool instanced = false;                      // several instances share it
};

struct Instance {
  uint32_t mesh = 0;
  uint32_t object = 0;
  uint32_t visibility = kVisibleAll;
  uint32_t material_offset = 0;  // into Scene::slot_materials
  uint32_t slot_count = 1;
  float random = 0;           // Object Info's random, [0, 1)
  bool mirrored = false;      // the transform reverses orientation
  Transform to_render;        // instanced: Mesh::positions to render space; else identity
  Transform from_render;      // its inverse
  Transform object_to_world;  // as described
  Transform world_to_object;  // singular transforms: zeros
};

class Scene {
 public:
  Scene();
  ~Scene();
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  // World position of the origin of render space. Rays, lights and SurfacePoint are in render
  // space, where float32 has its best resolution for what is in the scene.
  const std::array<double, 3>& origin() const { return origin_; }
  Vec3f to_world(Vec3f p) const;

  // The closest surface along the ray that `mask` (Visibility bits) sees.
  bool intersect(const Ray& ray, uint32_t mask, Hit& hit) const {
    return intersector_ != nullptr && intersector_->intersect(ray, mask, hit);
  }
  // Whether an opaque surface blocks the ray for shadows.
  bool occluded_by_opaque(const Ray& ray) const {
    return intersector_ != nullptr && intersector_->occluded(ray, kMaskOpaqueShadow);
  }
  // The closest surface that may let shadow rays through.
  bool intersect_transparent(const Ray& ray, Hit& hit) const {
    return intersector_ != nullptr && intersector_->intersect(ray, kMaskTransparentShadow, hit);
  }

  // Everything of SurfacePoint but ray_flags and depth.
  SurfacePoint surface_point(const Ray& ray, const Hit& hit) const;
  // The three corners of a triangle in render space.
  std::array<Vec3f, 3> triangle(uint32_t instance, uint32_t triangle) const;
  // The unit geometric normal of a triangle on its front side, in render space.
  Vec3f triangle_normal(uint32_t instance, uint32_t triangle) const;
  // Interpolated attribute (id as in attribute_names); {0,0,0,0} where the mesh has none.
  // One channel fills x, y and z alike with w = 1; two fill x and y; three have w = 1.
  Vec4f attribute(const SurfacePoint& point, uint32_t id) const;
  bool has_attribute(uint32_t mesh, uint32_t id) const;
  // The active UV map's coordinates, w = 1; zero where they were not kept.
  Vec3f uv(const SurfacePoint& point) const;
  uint32_t material_of(uint32_t instance, uint32_t triangle) const;
  // Radius of the picture's pixel footprint at p, metres: the step of bump mapping's differences.
  float footprint(Vec3f p) const;

  std::span<const Mesh> meshes;
  std::span<const Instance> instances;
  std::vector<ObjectDesc> objects;
  std::vector<uint32_t> slot_materials;
  std::vector<std::string> attribute_names;
  uint32_t uv_attribute = kNoIndex;  // of the UV pass
  std::vector<std::shared_ptr<const ImageTexture>> images;
  std::vector<std::shared_ptr<const Material>> materials;  // the last one is the grey default
  std::vector<float> material_pass_indices;
  std::shared_ptr<const Material> world;  // null: black
  uint32_t world_visibility = kVisibleAll;
  std::unique_ptr<const Camera> camera;
  // May refer to the scene that it was made for, which it then keeps alive.
  std::shared_ptr<const LightSampler> lights;
  FilmDesc film;
  Requirements requirements;
  std::vector<std::string> warnings;  // of what was compiled for this scene
  CompiledParts compiled;
  Vec3f center;  // bounding sphere of all geometry and finite lamps, render space
  float radius = 0;

 private:
  friend class SceneCompiler;
  friend std::shared_ptr<const Scene> with_view(const std::shared_ptr<const Scene>& scene,
                                                const CameraDesc& camera, const FilmDesc& film);

  std::array<double, 3> origin_{};
  std::shared_ptr<const Geometry> geometry_;  // what `meshes` and `instances` show
  const Intersector* intersector_ = nullptr;  // its own
  // The scene that `lights` refer to; null: this one.
  std::shared_ptr<const Scene> lights_home_;
  std::shared_ptr<const SceneSource> source_;  // null: a later compilation cannot share this
};

}  // namespace vernier
