// What instructions read of the surface point: coordinates, attributes, the ray that arrived.
#pragma once

#include <cstdint>

#include "math/vec.h"
#include "scene/surface_point.h"

namespace vernier {

enum class GeometryValue : uint8_t {
  kPosition,    // world space
  kNormal,      // of shading
  kTrueNormal,  // of the triangle
  kIncoming,    // toward the viewer
  kParametric,
  kBackfacing,
  kTangent,  // radial, about the object's z axis
  kGenerated,
  kObject,        // position in object space
  kObjectNormal,  // shading normal in object space
  kReflection,
};
Vec3f geometry_value(GeometryValue value, const SurfacePoint& point);

// How an attribute becomes a socket's value.
enum class AttributeUse : uint8_t {
  kVector,      // xyz; scalars are spread, w is 0 where the mesh lacks the attribute
  kFactor,      // scalar: the average of 3 or 4 channels, the first of 1 or 2
  kAlpha,       // scalar: the fourth channel; 1 where there is none
  kColorAlpha,  // scalar: the same, but 0 where the mesh lacks the attribute
};
Vec4f attribute_value(AttributeUse use, const SurfacePoint& point, uint32_t id);

enum class ObjectValue : uint8_t {
  kLocation,
  kColor,
  kAlpha,
  kObjectIndex,
  kMaterialIndex,
  kRandom,
};
Vec3f object_value(ObjectValue value, const SurfacePoint& point);

// In the order of the Light Path node's outputs.
enum class LightPathValue : uint8_t {
  kCamera,
  kShadow,
  kDiffuse,
  kGlossy,
  kSingular,
  kReflection,
  kTransmission,
  kVolumeScatter,
  kRayLength,
  kRayDepth,
  kDiffuseDepth,
  kGlossyDepth,
  kTransparentDepth,
  kTransmissionDepth,
  kPortalDepth,
};
float light_path_value(LightPathValue value, const SurfacePoint& point);

enum class CameraValue : uint8_t {
  kVector,
  kDepth,
  kDistance,
  kPosition,
  kWindow,  // [0, 1]^2 over the picture; zero for points outside it
};
Vec3f camera_value(CameraValue value, const SurfacePoint& point);

enum class VectorSpace : uint8_t { kWorld, kObject, kCamera };
enum class TransformKind : uint8_t { kVector, kPoint, kNormal };
Vec3f transform_between(TransformKind kind, VectorSpace from, VectorSpace to, Vec3f v,
                        const SurfacePoint& point);

// Normals and directions between the point's object and render space; normals come out unit.
Vec3f object_normal_to_render(const SurfacePoint& point, Vec3f n);
Vec3f render_normal_to_object(const SurfacePoint& point, Vec3f n);

Vec3f world_position(const SurfacePoint& point);

// Fresnel reflectance of unpolarised light at a dielectric of relative index eta.
float fresnel_dielectric(float cosine, float eta);
float fresnel_node(const SurfacePoint& point, float ior, Vec3f normal);
enum class LayerWeightKind : uint8_t { kFresnel, kFacing };
float layer_weight(LayerWeightKind kind, const SurfacePoint& point, float blend, Vec3f normal);

// The point moved by `step` metres along each of the tangents of Frame(ng).
enum class ShiftAxis : uint8_t { kX, kY };
struct ShiftedPoints {
  SurfacePoint x, y;

  ShiftedPoints(const SurfacePoint& point, float step);
};
// Length of bump mapping's differences at a point: `filter` times the pixel's width there.
float bump_step(const SurfacePoint& point, float filter);

}  // namespace vernier
