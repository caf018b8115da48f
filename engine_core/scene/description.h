// The description of a scene: plain data, the one thing that crosses from Blender to the core.
//
// The Python dataclasses of `engine_core.description` are its written specification (fields,
// shapes, units, defaults, validation); these structs mirror them. Large arrays are views into
// memory that the caller keeps alive until compile() returns.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "math/transform.h"
#include "math/vec.h"

namespace vernier {

enum class Domain : uint8_t { kPoint, kFace, kCorner };

// A named value on the elements of a mesh: `channels` (1 to 4) floats each.
struct AttributeDesc {
  std::string name;
  Domain domain = Domain::kPoint;
  int channels = 3;
  std::span<const float> data;
};

struct MeshDesc {
  std::string name;
  const void* identity = nullptr;    // equal and not null: the same mesh as in another description
  std::span<const float> positions;  // 3 per vertex, object space
  std::span<const int32_t> corner_vertices;  // vertex of each corner
  std::span<const int32_t> face_offsets;     // first corner of each face, and one past the last
  std::span<const int32_t> face_materials;   // slot of each face; empty: slot 0
  Domain normal_domain = Domain::kFace;      // kFace: flat, `normals` is empty
  std::span<const float> normals;            // 3 per element of normal_domain
  std::vector<AttributeDesc> attributes;
  // Object-space box that the generated coordinates map to [0,1]^3.
  Vec3f texture_space_min{-1, -1, -1}, texture_space_max{1, 1, 1};
  std::string active_uv;     // the UV map that nodes which name none use
  std::string active_color;  // the colour attribute that nodes which name none use
};

// Bits of ray visibility, as Blender's object and light options have them.
enum Visibility : uint32_t {
  kVisibleCamera = 1u << 0,
  kVisibleDiffuse = 1u << 1,
  kVisibleGlossy = 1u << 2,
  kVisibleTransmission = 1u << 3,
  kVisibleShadow = 1u << 4,
  kVisibleAll = (1u << 5) - 1u,
  // What the light that scatters in the scene sees, whichever end its path is traced from.
  kVisibleScattered = kVisibleAll & ~kVisibleCamera,
};

struct InstancesDesc {
  std::span<const int32_t> mesh;          // index into meshes
  std::span<const float> transform;       // 12 each: rows of the 3x4 object-to-world matrix
  std::span<const uint32_t> visibility;   // Visibility bits
  std::span<const int32_t> material_set;  // index into material_sets
  std::span<const float> random;          // Object Info's random, [0, 1)
  std::span<const int32_t> object;        // index into objects
};

// What an instance's object tells to shaders and passes.
struct ObjectDesc {
  std::string name;
  std::array<float, 4> color{1, 1, 1, 1};
  std::array<float, 3> location{};
  float pass_index = 0.0f;
  bool shadow_catcher = false;
  bool holdout = false;

  bool operator==(const ObjectDesc&) const = default;
};

// An input of a shader node: a constant, or (node >= 0) another node's output.
struct NodeInput {
  std::string name;              // Blender's socket identifier
  std::array<float, 4> value{};  // scalar in [0]; vector in [0..2]; colour RGBA
  int32_t node = -1;
  std::string output;  // the source's socket identifier

  bool operator==(const NodeInput&) const = default;
};

using ParamValue = std::variant<bool, int64_t, double, std::string, std::vector<float>>;

// A shader node, by Blender's vocabulary: kind is its bl_idname ("ShaderNodeBsdfPrincipled"),
// inputs are named by socket identifier, params by RNA property with enum identifiers as strings.
struct NodeDesc {
  std::string kind;
  std::string name;
  std::vector<NodeInput> inputs;
  std::map<std::string, ParamValue> params;

  bool operator==(const NodeDesc&) const = default;
};

struct NodeLink {
  int32_t node = -1;
  std::string output;

  bool operator==(const NodeLink&) const = default;
};

// A flat node tree: groups, reroutes and muted nodes are already resolved. Links may not be cyclic.
struct GraphDesc {
  std::vector<NodeDesc> nodes;
  NodeLink surface;  // the shader that is the result; node -1: none (black)

  bool operator==(const GraphDesc&) const = default;
};

struct MaterialDesc {
  std::string name;
  GraphDesc graph;
  float pass_index = 0.0f;

  bool operator==(const MaterialDesc&) const = default;
};

enum class PixelType : uint8_t { kUint8, kFloat32 };
enum class ImageEncoding : uint8_t { kSrgb, kLinear };  // kSrgb: decoded by IEC 61966-2-1
enum class AlphaMode : uint8_t { kStraight, kPremultiplied, kChannelPacked, kNone };

// Pixels in rows from the bottom, `channels` (1, 3 or 4) each. Width 0: the image is missing
// and is drawn magenta, as Cycles does.
struct ImageDesc {
  std::string name;
  const void* identity = nullptr;  // as MeshDesc's
  int32_t width = 0, height = 0, channels = 4;
  PixelType type = PixelType::kUint8;
  ImageEncoding encoding = ImageEncoding::kSrgb;
  AlphaMode alpha = AlphaMode::kStraight;
  std::span<const std::byte> pixels;
};

enum class LightKind : uint8_t { kPoint, kSpot, kSun, kArea };
enum class AreaShape : uint8_t { kRectangle, kEllipse };

struct LightDesc {
  std::string name;
  LightKind kind = LightKind::kPoint;
  Transform transform;           // light to world; it shines along -z
  Color emission{1, 1, 1};       // colour times power: watts (sun: W/m^2 at normal incidence)
  bool normalize = true;         // area lights: emission is spread over the surface
  float radius = 0.0f;           // point, spot: metres
  bool soft_falloff = true;      // point, spot: Blender's soft falloff
  float spot_angle = 0.785398f;  // full cone angle, radians
  float spot_blend = 0.15f;      // [0, 1]
  AreaShape shape = AreaShape::kRectangle;
  float size_x = 1.0f, size_y = 1.0f;  // metres, before `transform`
  float spread = 3.14159265f;          // full angle, radians
  float sun_angle = 0.0f;              // full angular diameter, radians
  uint32_t visibility = kVisibleAll & ~kVisibleCamera;
  bool cast_shadow = true;
  bool use_mis = true;
  GraphDesc graph;  // emission shader that multiplies; empty: none

  bool operator==(const LightDesc&) const = default;
};

struct WorldDesc {
  GraphDesc graph;  // a Background shader; empty: black
  uint32_t visibility = kVisibleAll;

  bool operator==(const WorldDesc&) const = default;
};

enum class CameraKind : uint8_t { kPerspective, kOrthographic };

struct CameraDesc {
  CameraKind kind = CameraKind::kPerspective;
  Transform transform;  // camera to world, scale removed; it looks along -z, +y is up
  // The picture's full rectangle (before any border) on the plane z = -1 (perspective: tangents)
  // or in metres (orthographic): left, right, bottom, top. Lens shift is part of it.
  std::array<float, 4> window{-0.36f, 0.36f, -0.2025f, 0.2025f};
  float clip_start = 0.1f, clip_end = 1000.0f;  // metres along the view axis
  float aperture_radius = 0.0f;                 // metres; 0: pinhole
  float focus_distance = 10.0f;                 // metres along the view axis
  int32_t blades = 0;                           // fewer than 3: a disk
  float blade_rotation = 0.0f;                  // radians
  float aperture_ratio = 1.0f;                  // anamorphic: width of the bokeh is divided by it
};

enum class FilterKind : uint8_t { kBox, kGaussian, kBlackmanHarris };

struct FilmDesc {
  int32_t width = 640, height = 360;            // the full frame in pixels
  std::array<int32_t, 4> crop{0, 0, 640, 360};  // x0, y0, x1, y1: what is rendered; y up
  FilterKind filter = FilterKind::kBlackmanHarris;
  float filter_width = 1.5f;  // pixels, as Blender names it
  float exposure = 1.0f;
  bool transparent = false;  // the world leaves alpha 0 to camera rays
  // Surfaces less opaque than this leave the passes of the first surface to those behind; [0, 1].
  float pass_alpha_threshold = 0.5f;
};

struct SceneDescription {
  std::vector<MeshDesc> meshes;
  std::vector<std::vector<int32_t>> material_sets;  // material of each slot; -1: the default
  InstancesDesc instances;
  std::vector<ObjectDesc> objects;
  std::vector<MaterialDesc> materials;
  std::vector<ImageDesc> images;
  std::vector<LightDesc> lights;
  WorldDesc world;
  CameraDesc camera;
  FilmDesc film;
};

}  // namespace vernier
