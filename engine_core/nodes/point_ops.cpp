#include "nodes/point_ops.h"

#include "camera/camera.h"
#include "math/transform.h"
#include "scene/scene.h"

namespace vernier {
namespace {

// Where a point is not on a mesh it is on a lamp, or it is a direction of the world.
bool on_mesh(const SurfacePoint& point) { return point.instance != kNoIndex; }

// Points of lamps have a distance; directions of the world have none.
bool in_world(const SurfacePoint& point) {
  return !on_mesh(point) && !(point.ray_length > 0.0f && point.ray_length < kInfinity);
}

const Instance& instance_of(const SurfacePoint& point) {
  return point.scene->instances[point.instance];
}
const Mesh& mesh_of(const SurfacePoint& point) { return point.scene->meshes[point.mesh]; }

Vec3f object_position(const SurfacePoint& point) {
  if (!on_mesh(point)) {
    return world_position(point);
  }
  return mesh_of(point).to_object.point(instance_of(point).from_render.point(point.p));
}

// Coordinates that span [0, 1] over the mesh's texture space.
Vec3f generated(const SurfacePoint& point) {
  const Vec3f p = object_position(point);
  if (!on_mesh(point)) {
    return p;
  }
  const Mesh& mesh = mesh_of(point);
  Vec3f g;
  for (int i = 0; i < 3; ++i) {
    const float lo = mesh.texture_space_min[i];
    const float extent = mesh.texture_space_max[i] - lo;
    // Blender gives a flat axis the half size 1.
    g[i] = extent > 0.0f ? (p[i] - lo) / extent : 0.5f + 0.5f * (p[i] - lo);
  }
  return g;
}

// About the object's z axis, through the middle of its texture space (Cycles: primitive_tangent).
Vec3f radial_tangent(const SurfacePoint& point) {
  const Vec3f g = generated(point);
  return object_normal_to_render(point, {-(g.y - 0.5f), g.x - 0.5f, 0.0f});
}

Vec3f to_world(const SurfacePoint& point, Vec3f p) {
  if (point.scene == nullptr) {
    return p;
  }
  const std::array<double, 3>& o = point.scene->origin();
  return {static_cast<float>(p.x + o[0]), static_cast<float>(p.y + o[1]),
          static_cast<float>(p.z + o[2])};
}

Vec3f to_render(const SurfacePoint& point, Vec3f p) {
  if (point.scene == nullptr) {
    return p;
  }
  const std::array<double, 3>& o = point.scene->origin();
  return {static_cast<float>(p.x - o[0]), static_cast<float>(p.y - o[1]),
          static_cast<float>(p.z - o[2])};
}

const Camera* camera_of(const SurfacePoint& point) {
  return point.scene == nullptr ? nullptr : point.scene->camera.get();
}

}  // namespace

// In the world, as in Cycles, the position is the ray's direction.
Vec3f world_position(const SurfacePoint& point) {
  return in_world(point) ? -point.wo : to_world(point, point.p);
}

Vec3f object_normal_to_render(const SurfacePoint& point, Vec3f n) {
  if (!on_mesh(point)) {
    return normalize(n);
  }
  return normalize(instance_of(point).from_render.transposed_vector(
      mesh_of(point).to_object.transposed_vector(n)));
}

Vec3f render_normal_to_object(const SurfacePoint& point, Vec3f n) {
  if (!on_mesh(point)) {
    return n;
  }
  const Vec3f local = instance_of(point).to_render.transposed_vector(n);
  const Transform& to_object = mesh_of(point).to_object;
  return normalize(to_object.is_identity() ? local : inverse(to_object).transposed_vector(local));
}

Vec3f geometry_value(GeometryValue value, const SurfacePoint& point) {
  switch (value) {
    case GeometryValue::kPosition:
      return world_position(point);
    case GeometryValue::kNormal:
      return in_world(point) ? point.wo : point.ns;
    case GeometryValue::kTrueNormal:
      return in_world(point) ? point.wo : point.ng;
    case GeometryValue::kIncoming:
      return point.wo;
    case GeometryValue::kParametric:
      return {1.0f - point.u - point.v, point.u, 0.0f};
    case GeometryValue::kBackfacing:
      return splat(point.backfacing ? 1.0f : 0.0f);
    case GeometryValue::kTangent:
      return cross(point.ns, normalize(cross(radial_tangent(point), point.ns)));
    case GeometryValue::kGenerated:
      return generated(point);
    case GeometryValue::kObject:
      return object_position(point);
    case GeometryValue::kObjectNormal:
      return in_world(point) ? point.wo : render_normal_to_object(point, point.ns);
    case GeometryValue::kReflection:
      return on_mesh(point) ? point.ns * (2.0f * dot(point.wo, point.ns)) - point.wo : point.wo;
  }
  return {};
}

Vec4f attribute_value(AttributeUse use, const SurfacePoint& point, uint32_t id) {
  if (!on_mesh(point) || !point.scene->has_attribute(point.mesh, id)) {
    const float alpha = use == AttributeUse::kAlpha ? 1.0f : 0.0f;
    return {alpha, alpha, alpha, 0.0f};
  }
  const int channels = mesh_of(point).attributes[id].channels;
  const Vec4f v = point.scene->attribute(point, id);
  const auto all = [](float x) { return Vec4f{x, x, x, 1.0f}; };
  switch (use) {
    case AttributeUse::kVector:
      return channels == 1 ? all(v.x) : v;
    case AttributeUse::kFactor:
      return all(channels <= 2 ? v.x : average(v.xyz()));
    case AttributeUse::kAlpha:
    case AttributeUse::kColorAlpha:
      return all(channels == 4 ? v.w : 1.0f);
  }
  return {};
}

Vec3f object_value(ObjectValue value, const SurfacePoint& point) {
  if (!on_mesh(point)) {
    return {};
  }
  const Instance& instance = instance_of(point);
  const ObjectDesc& object = point.scene->objects[instance.object];
  switch (value) {
    case ObjectValue::kLocation:
      return {object.location[0], object.location[1], object.location[2]};
    case ObjectValue::kColor:
      return {object.color[0], object.color[1], object.color[2]};
    case ObjectValue::kAlpha:
      return splat(object.color[3]);
    case ObjectValue::kObjectIndex:
      return splat(object.pass_index);
    case ObjectValue::kMaterialIndex:
      return splat(point.scene->material_pass_indices[point.material]);
    case ObjectValue::kRandom:
      return splat(instance.random);
  }
  return {};
}

float light_path_value(LightPathValue value, const SurfacePoint& point) {
  const auto flag = [&](uint32_t bits) { return (point.ray_flags & bits) != 0 ? 1.0f : 0.0f; };
  switch (value) {
    case LightPathValue::kCamera:
      return flag(kRayCamera);
    case LightPathValue::kShadow:
      return flag(kRayShadow);
    case LightPathValue::kDiffuse:
      return flag(kRayDiffuse);
    case LightPathValue::kGlossy:
      return flag(kRayGlossy);
    case LightPathValue::kSingular:
      return flag(kRaySingular);
    case LightPathValue::kReflection:
      return flag(kRayReflection);
    case LightPathValue::kTransmission:
      return flag(kRayTransmission);
    case LightPathValue::kVolumeScatter:
      return 0.0f;
    case LightPathValue::kRayLength:
      return point.ray_length;
    case LightPathValue::kRayDepth:
      return point.depth.total;
    case LightPathValue::kDiffuseDepth:
      return point.depth.diffuse;
    case LightPathValue::kGlossyDepth:
      return point.depth.glossy;
    case LightPathValue::kTransparentDepth:
      return point.depth.transparent;
    case LightPathValue::kTransmissionDepth:
      return point.depth.transmission;
    case LightPathValue::kPortalDepth:
      return 0.0f;
  }
  return 0.0f;
}

// Blender's camera coordinates have z forward.
Vec3f camera_value(CameraValue value, const SurfacePoint& point) {
  const Camera* camera = camera_of(point);
  if (camera == nullptr) {
    return {};
  }
  if (value == CameraValue::kWindow) {
    const auto seen = camera->connect(point.p, {0.5f, 0.5f});
    const FilmDesc& film = point.scene->film;
    return seen ? Vec3f{seen->raster.x / static_cast<float>(film.width),
                        seen->raster.y / static_cast<float>(film.height), 0.0f}
                : Vec3f{};
  }
  Vec3f p = camera->to_camera(point.p - camera->position());
  p.z = -p.z;
  switch (value) {
    case CameraValue::kVector:
      return normalize(p);
    case CameraValue::kDepth:
      return splat(p.z);
    case CameraValue::kDistance:
      return splat(length(p));
    case CameraValue::kPosition:
      return p;
    case CameraValue::kWindow:
      break;
  }
  return {};
}

Vec3f transform_between(TransformKind kind, VectorSpace from, VectorSpace to, Vec3f v,
                        const SurfacePoint& point) {
  if (from == to || !on_mesh(point)) {
    return v;
  }
  const bool normal = kind == TransformKind::kNormal, is_point = kind == TransformKind::kPoint;
  const Instance& instance = instance_of(point);
  const Mesh& mesh = mesh_of(point);
  const Camera* camera = camera_of(point);
  // 1. To render space.
  if (from == VectorSpace::kObject) {
    const Transform from_object = inverse(mesh.to_object);
    v = normal     ? object_normal_to_render(point, v)
        : is_point ? instance.to_render.point(from_object.point(v))
                   : instance.to_render.vector(from_object.vector(v));
  } else if (from == VectorSpace::kCamera && camera != nullptr) {
    const Vec3f x = camera->to_camera({1, 0, 0}), y = camera->to_camera({0, 1, 0}),
                z = camera->to_camera({0, 0, 1});
    const Vec3f c{v.x, v.y, -v.z};
    v = {dot(x, c), dot(y, c), dot(z, c)};
    v = normal ? normalize(v) : (is_point ? v + camera->position() : v);
  } else if (is_point) {
    v = to_render(point, v);
  }
  // 2. From render space.
  if (to == VectorSpace::kObject) {
    return normal     ? render_normal_to_object(point, v)
           : is_point ? mesh.to_object.point(instance.from_render.point(v))
                      : mesh.to_object.vector(instance.from_render.vector(v));
  }
  if (to == VectorSpace::kCamera && camera != nullptr) {
    v = camera->to_camera(is_point ? v - camera->position() : v);
    v = {v.x, v.y, -v.z};
    return normal ? normalize(v) : v;
  }
  return is_point ? to_world(point, v) : v;
}

float fresnel_dielectric(float cosine, float eta) {
  // Cosine of the refracted direction times eta, from Snell's law.
  const float c = std::abs(cosine);
  const float g2 = eta * eta - 1.0f + c * c;
  if (g2 <= 0.0f) {
    return 1.0f;
  }
  const float g = std::sqrt(g2);
  const float a = (g - c) / (g + c);
  const float b = ((g + c) * c - 1.0f) / ((g - c) * c + 1.0f);
  return 0.5f * a * a * (1.0f + b * b);
}

float fresnel_node(const SurfacePoint& point, float ior, Vec3f normal) {
  const float inside = std::max(ior, 1e-5f);  // Cycles' least index
  return fresnel_dielectric(dot(point.wo, normal), point.backfacing ? 1.0f / inside : inside);
}

float layer_weight(LayerWeightKind kind, const SurfacePoint& point, float blend, Vec3f normal) {
  const float cosine = dot(point.wo, normal);
  // The least distances from a blend of 1 are Cycles'.
  if (kind == LayerWeightKind::kFresnel) {
    const float eta = std::max(1.0f - blend, 1e-5f);
    return fresnel_dielectric(cosine, point.backfacing ? eta : 1.0f / eta);
  }
  float facing = std::abs(cosine);
  if (blend != 0.5f) {
    const float b = clamp(blend, 0.0f, 1.0f - 1e-5f);
    facing = std::pow(facing, b < 0.5f ? 2.0f * b : 0.5f / (1.0f - b));
  }
  return 1.0f - facing;
}

ShiftedPoints::ShiftedPoints(const SurfacePoint& point, float step) : x(point), y(point) {
  if (!on_mesh(point)) {
    return;
  }
  const Frame frame(point.ng);
  const std::array<Vec3f, 3> corner = point.scene->triangle(point.instance, point.triangle);
  const Vec3f e1 = corner[1] - corner[0], e2 = corner[2] - corner[0];
  const Vec3f n = cross(e1, e2);
  const float squared = length_squared(n);
  // In the plane of the triangle offset = du e1 + dv e2; crossed with e2 and e1 and taken along n
  // this gives du and dv as products of the offset with these.
  const float inverse = squared > 0.0f ? 1.0f / squared : 0.0f;
  const Vec3f along_u = cross(e2, n) * inverse, along_v = cross(n, e1) * inverse;
  const auto move = [&](SurfacePoint& moved, Vec3f offset) {
    moved.p += offset;
    moved.u += dot(offset, along_u);
    moved.v += dot(offset, along_v);
  };
  move(x, frame.s * step);
  move(y, frame.t * step);
}

float bump_step(const SurfacePoint& point, float filter) {
  if (!on_mesh(point)) {
    return 0.0f;
  }
  // Far below the footprint a difference would be one of rounding errors: 64 of them keep the
  // slope within 2 %.
  const float pixel = 2.0f * point.scene->footprint(point.p);
  return std::max(filter * pixel, 64.0f * max_component(point.p_error));
}

}  // namespace vernier
