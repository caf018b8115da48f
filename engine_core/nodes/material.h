// A compiled material: what a Blender shader node graph does to light at a point.
//
// compile_material() validates the graph, folds constants, drops what nothing reads and leaves a
// short program over registers that ends in weighted closures. A constant material has no program:
// its closures are ready and only their set-up for the direction is done.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "math/vec.h"
#include "scene/description.h"
#include "scene/surface_point.h"

namespace vernier {

class Bsdf;
class ImageTexture;
struct MaterialCode;

// The attribute name that stands for a mesh's active UV map: what nodes that name no map read.
inline constexpr std::string_view kActiveUvAttribute = "";
// The attribute name that stands for a mesh's active colour attribute.
inline constexpr std::string_view kActiveColorAttribute = ":color";
// Prefix of tangent attributes: "tangent:" + UV map (the prefix alone: of the active UV map).
// 4 channels: the unit tangent in object space and the sign of the bitangent.
inline constexpr std::string_view kTangentAttributePrefix = "tangent:";

// What compilation reads and adds to besides the graph itself.
class NodeContext {
 public:
  // `images` by index of the description's images; they must outlive the compiled materials.
  // `attribute_names` and `warnings` are appended to.
  NodeContext(std::span<const std::shared_ptr<const ImageTexture>> images,
              std::vector<std::string>& attribute_names, std::vector<std::string>& warnings);

  // The index of `name` in the attribute names; appended when it is new.
  uint32_t attribute_id(std::string_view name);
  // The image, or null where the index is -1 or out of range.
  const ImageTexture* image(int64_t index) const;
  // Records a warning; an equal one is recorded once.
  void warn(std::string message);

 private:
  std::span<const std::shared_ptr<const ImageTexture>> images_;
  std::vector<std::string>& attribute_names_;
  std::vector<std::string>& warnings_;
  std::unordered_map<std::string, uint32_t> attribute_ids_;
  std::unordered_map<std::string, uint32_t> warning_ids_;
};

// What is known of a material before any point is shaded.
struct MaterialTraits {
  bool is_constant = true;         // evaluate() runs no program
  bool is_emissive = false;        // emission() may be non-zero
  bool emission_constant = true;   // emission() is average_emission everywhere
  bool maybe_transparent = false;  // transparency() may be non-zero
  // What closures and values depend on besides the point:
  bool side_dependent = false;           // the side of the surface that it is seen from
  bool direction_dependent = false;      // more of the direction wo
  bool path_dependent = false;           // ray_flags, ray_length or depth: the path so far
  bool emission_view_dependent = false;  // any of these, for emission() alone
  bool uses_bump = false;                // normals other than SurfacePoint::ns occur
  int emission_image_width = 0;          // pixels of the widest image that emission() reads
  uint8_t lobes = 0;                     // union of the LobeBits that can occur
  Color average_emission;                // radiance; exact when emission_constant, else an estimate
  std::vector<uint32_t> attributes;      // ids that are read, each once
};

class Material {
 public:
  Material(std::string name, std::unique_ptr<const MaterialCode> code, MaterialTraits traits);
  ~Material();
  Material(const Material&) = delete;
  Material& operator=(const Material&) = delete;

  // Adds the closures at `point` to `bsdf`, on which begin(point) was called; the caller calls
  // finish().
  void evaluate(const SurfacePoint& point, Bsdf& bsdf) const;
  // Radiance emitted toward point.wo, finite and non-negative unless a node made it negative.
  // For the world, point.wo is minus the ray's direction; for lamps, point is on the lamp.
  Color emission(const SurfacePoint& point) const;
  // Weight of the closures that pass light straight through: what a shadow ray is multiplied by.
  Color transparency(const SurfacePoint& point) const;

  const MaterialTraits& traits() const { return traits_; }
  const std::string& name() const { return name_; }
  // Instructions that evaluate() runs; 0 for a constant material.
  size_t program_length() const;
  // Vec4f registers that evaluate() needs.
  size_t register_count() const;

 private:
  void prepare();

  std::string name_;
  std::unique_ptr<const MaterialCode> code_;
  MaterialTraits traits_;
  // The lobes of a constant material, as seen from its front and its back; null where they must be
  // added anew at every point.
  std::array<std::unique_ptr<const Bsdf>, 2> prepared_;
};

// Compiles a graph. Throws std::invalid_argument naming the material, and the node, when a link's
// index is out of range or links form a cycle. Everything else that cannot be honoured (a node
// kind, socket, parameter or enum item that is unknown) is a warning that names the material, the
// node and what was done instead.
std::unique_ptr<Material> compile_material(const GraphDesc& graph, std::string_view name,
                                           NodeContext& context);

}  // namespace vernier
