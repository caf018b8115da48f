#include "nodes/normal_ops.h"

#include "math/frame.h"
#include "nodes/point_ops.h"
#include "scene/scene.h"

namespace vernier {
namespace {

bool has_tangent(const SurfacePoint& point, uint32_t attribute) {
  return point.instance != kNoIndex && point.scene->has_attribute(point.mesh, attribute);
}

// In the plane orthogonal to the shading normal; zero where the direction is along it.
Vec3f tangent_beside_normal(const SurfacePoint& point, Vec3f direction) {
  return cross(point.ns, normalize(cross(direction, point.ns)));
}

Vec3f usable_normal(Vec3f n, const SurfacePoint& point) {
  return is_finite(n) && !is_black(n) ? n : point.ns;
}

}  // namespace

Vec3f normal_map(NormalSpace space, const SurfacePoint& point, Color color, float strength,
                 uint32_t tangent_attribute) {
  Vec3f n = color * 2.0f - splat(1.0f);
  const float side = point.backfacing ? -1.0f : 1.0f;
  if (space == NormalSpace::kTangent) {
    if (!has_tangent(point, tangent_attribute)) {
      return point.ns;
    }
    const Vec4f t = point.scene->attribute(point, tangent_attribute);
    // The map belongs to the surface as it is wound.
    const Vec3f normal = render_normal_to_object(point, point.ns * side);
    const Vec3f bitangent = cross(normal, t.xyz()) * t.w;
    n = {n.x * strength, n.y * strength, lerp(1.0f, n.z, saturate(strength))};
    n = normalize(t.xyz() * n.x + bitangent * n.y + normal * n.z);
    return usable_normal(object_normal_to_render(point, n) * side, point);
  }
  if (space == NormalSpace::kBlenderObject || space == NormalSpace::kBlenderWorld) {
    n.y = -n.y;
    n.z = -n.z;
  }
  const bool in_object = space == NormalSpace::kObject || space == NormalSpace::kBlenderObject;
  n = (in_object ? object_normal_to_render(point, n) : normalize(n)) * side;
  if (strength != 1.0f) {
    n = normalize(point.ns + (n - point.ns) * std::max(strength, 0.0f));
  }
  return usable_normal(n, point);
}

// Surface gradient (Mikkelsen 2010, "Bump Mapping Unparametrized Surfaces on the GPU").
Vec3f bump_normal(const SurfacePoint& point, Vec3f normal, const BumpHeights& heights,
                  float strength, float distance, float step) {
  if (!(step > 0.0f)) {
    return normal;
  }
  const Frame frame(point.ng);  // the axes of ShiftedPoints
  const Vec3f rx = cross(frame.t, normal), ry = cross(normal, frame.s);
  const float determinant = dot(frame.s, rx);
  const float slope = distance / step;
  const Vec3f gradient =
      rx * ((heights.x - heights.center) * slope) + ry * ((heights.y - heights.center) * slope);
  const Vec3f bumped =
      normalize(normal * std::abs(determinant) - gradient * (determinant < 0.0f ? -1.0f : 1.0f));
  if (is_black(bumped) || !is_finite(bumped)) {
    return normal;
  }
  const float s = std::max(strength, 0.0f);
  const Vec3f blended = normalize(bumped * s + normal * (1.0f - s));
  return is_black(blended) ? normal : blended;
}

Vec3f radial_tangent(TangentAxis axis, const SurfacePoint& point) {
  const Vec3f g = geometry_value(GeometryValue::kGenerated, point) - splat(0.5f);
  const Vec3f around = axis == TangentAxis::kX   ? Vec3f{0.0f, -g.z, g.y}
                       : axis == TangentAxis::kY ? Vec3f{-g.z, 0.0f, g.x}
                                                 : Vec3f{-g.y, g.x, 0.0f};
  return tangent_beside_normal(point, object_normal_to_render(point, around));
}

Vec3f uv_tangent(const SurfacePoint& point, uint32_t tangent_attribute) {
  if (!has_tangent(point, tangent_attribute)) {
    return {};
  }
  const Vec3f t = point.scene->attribute(point, tangent_attribute).xyz();
  return tangent_beside_normal(point, object_normal_to_render(point, t));
}

}  // namespace vernier
