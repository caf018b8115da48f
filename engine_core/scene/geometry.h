// Shapes and their places with the hierarchy over them: what successive scenes share as long as
// only shading, lights or the view change.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "embree/intersector.h"
#include "scene/description.h"
#include "scene/scene.h"

namespace vernier {

// An axis-aligned box in float64: world coordinates before an origin is chosen.
struct Box {
  std::array<double, 3> lower{HUGE_VAL, HUGE_VAL, HUGE_VAL};
  std::array<double, 3> upper{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};

  bool empty() const { return lower[0] > upper[0]; }
  void add(const std::array<double, 3>& p);
  // The eight corners of a box under a matrix of three rows of four.
  void add_transformed(const Box& box, std::span<const float> m);
};

// A point under a matrix of three rows of four.
std::array<double, 3> transform_point(std::span<const float> m, const std::array<double, 3>& p);

struct Geometry {
  std::vector<Mesh> meshes;
  std::vector<Instance> instances;
  Box bounds;                                // of all instances, world space
  std::array<double, 3> origin{};            // of render space, world space
  std::vector<std::string> warnings;         // a sentence each, for the user
  std::unique_ptr<Intersector> intersector;  // null: there is nothing to meet
};

// What geometry is made of besides the description.
struct GeometryInput {
  Box bounds;                                    // of all instances, world space
  std::array<double, 3> origin{};                // of render space
  std::vector<std::string> warnings;             // kept with the geometry
  std::span<const std::string> attribute_names;  // that materials read
  std::span<const uint32_t> masks;               // ray mask of each instance
  std::span<const uint32_t> material_offsets;    // of each material set
  std::span<const uint32_t> slot_counts;         // of each material set
  bool fast_build = false;            // a hierarchy that is built sooner and traversed slower
  std::function<void()> meshes_read;  // called when the description's meshes are needed no more
};

// Bounds of each mesh, object space.
std::vector<Box> bounds_of_meshes(const SceneDescription& desc, int threads);
// Bounds of all instances, world space, from those of the meshes.
Box bounds_of_instances(const SceneDescription& desc, std::span<const Box> meshes);

// `threads` 0: all there are; `cancelled` is polled. Throws as compile() does.
std::shared_ptr<const Geometry> compile_geometry(const SceneDescription& desc,
                                                 const GeometryInput& input, int threads,
                                                 const std::function<bool()>& cancelled);

}  // namespace vernier
