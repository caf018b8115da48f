#include "scene/scene.h"

#include <algorithm>
#include <array>

#include "camera/camera.h"
#include "lights/light_sampler.h"
#include "nodes/material.h"
#include "scene/geometry.h"
#include "textures/image.h"

namespace vernier {
namespace {

// sum_i b_i v_i for the barycentric weights of a hit.
template <typename T>
T interpolate(T a, T b, T c, float u, float v) {
  return a * (1.0f - u - v) + b * u + c * v;
}

using Vec3d = std::array<double, 3>;

Vec3d difference(Vec3f a, Vec3f b) {
  return {static_cast<double>(a.x) - static_cast<double>(b.x),
          static_cast<double>(a.y) - static_cast<double>(b.y),
          static_cast<double>(a.z) - static_cast<double>(b.z)};
}
double dot(const Vec3d& a, const Vec3d& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec3d cross(const Vec3d& a, const Vec3d& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// The weights of b and c where the ray (of the triangle's own space) is at t. Embree says 0 and 0
// wherever the sum that these are ratios to is below 1e-18 (min_rcp_input in its
// triangle_intersector_pluecker.h): on triangles of 1e-6 units in instances that are enlarged by as
// much, which would have all of their light at one corner.
Vec2f weights_at(Vec3f a, Vec3f b, Vec3f c, Vec3f origin, Vec3f direction, float t) {
  const Vec3d e1 = difference(b, a), e2 = difference(c, a), n = cross(e1, e2);
  Vec3d q = difference(origin, a);
  for (int axis = 0; axis < 3; ++axis) {
    q[static_cast<size_t>(axis)] += static_cast<double>(direction[axis]) * static_cast<double>(t);
  }
  const double square = dot(n, n);
  if (!(square > 0.0)) {
    return {};
  }
  const double u = std::clamp(dot(cross(q, e2), n) / square, 0.0, 1.0);
  const double v = std::clamp(dot(cross(e1, q), n) / square, 0.0, 1.0 - u);
  return {static_cast<float>(u), static_cast<float>(v)};
}

}  // namespace

Scene::Scene() = default;
Scene::~Scene() = default;

Vec3f Scene::to_world(Vec3f p) const {
  return {static_cast<float>(static_cast<double>(p.x) + origin_[0]),
          static_cast<float>(static_cast<double>(p.y) + origin_[1]),
          static_cast<float>(static_cast<double>(p.z) + origin_[2])};
}

SurfacePoint Scene::surface_point(const Ray& ray, const Hit& hit) const {
  const Instance& instance = instances[hit.instance];
  const Mesh& mesh = meshes[instance.mesh];
  const auto& t = mesh.triangles[hit.triangle];
  const Vec3f a = mesh.positions[t[0]], b = mesh.positions[t[1]], c = mesh.positions[t[2]];
  SurfacePoint s;
  s.scene = this;
  Vec2f weights{hit.u, hit.v};
  if (hit.u == 0.0f && hit.v == 0.0f) {
    weights = mesh.instanced ? weights_at(a, b, c, instance.from_render.point(ray.o),
                                          instance.from_render.vector(ray.d), hit.t)
                             : weights_at(a, b, c, ray.o, ray.d, hit.t);
  }
  s.u = weights.x, s.v = weights.y;
  s.instance = hit.instance, s.mesh = instance.mesh, s.triangle = hit.triangle;
  s.material = material_of(hit.instance, hit.triangle);

  // The point from its barycentric coordinates, not from the ray: its error is then bounded by the
  // triangle's own coordinates, however long the ray was (Pharr et al. 2023, section 6.8.4). The
  // bound also covers the intersection test of the next ray, whose rounding is of the same size.
  const float w = 1.0f - s.u - s.v;
  s.p = a * w + b * s.u + c * s.v;
  s.p_error = (abs(a) + abs(b) + abs(c)) * gamma(8);
  Vec3f ng = cross(b - a, c - a);
  if (mesh.instanced) {
    const Vec3f local = s.p;
    s.p = instance.to_render.point(local);
    s.p_error = instance.to_render.point_error(local, s.p_error);
    // The next ray is taken to object space, which rounds once more.
    const Vec3f back = instance.from_render.point_error(s.p, {});
    const auto& m = instance.to_render.m;
    for (int r = 0; r < 3; ++r) {
      const auto i = static_cast<size_t>(4 * r);
      s.p_error[r] +=
          std::abs(m[i]) * back.x + std::abs(m[i + 1]) * back.y + std::abs(m[i + 2]) * back.z;
    }
    ng = instance.from_render.transposed_vector(ng);
  } else if (instance.mirrored) {
    ng = -ng;
  }
  s.ng = normalize(ng);
  const float direction_length = length(ray.d);
  s.wo = ray.d * (-1.0f / direction_length);
  s.ray_length = hit.t * direction_length;

  s.ns = s.ng;
  if (mesh.normal_domain != Domain::kFace) {
    const auto& corner = mesh.normal_domain == Domain::kPoint ? t : mesh.corners[hit.triangle];
    const Vec3f n = interpolate(mesh.normals[corner[0]], mesh.normals[corner[1]],
                                mesh.normals[corner[2]], s.u, s.v);
    const Vec3f ns = normalize(mesh.instanced ? instance.world_to_object.transposed_vector(n) : n);
    if (!(ns == Vec3f{})) {
      s.ns = ns;
    }
  }
  s.backfacing = dot(s.ng, s.wo) < 0.0f;
  if (s.backfacing) {
    s.ng = -s.ng;
    s.ns = -s.ns;
  }
  return s;
}

std::array<Vec3f, 3> Scene::triangle(uint32_t instance, uint32_t triangle) const {
  const Instance& i = instances[instance];
  const Mesh& mesh = meshes[i.mesh];
  const auto& t = mesh.triangles[triangle];
  std::array<Vec3f, 3> p{mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]};
  if (mesh.instanced) {
    for (Vec3f& q : p) {
      q = i.to_render.point(q);
    }
  }
  return p;
}

Vec3f Scene::triangle_normal(uint32_t instance, uint32_t triangle) const {
  const Instance& i = instances[instance];
  const Mesh& mesh = meshes[i.mesh];
  const auto& t = mesh.triangles[triangle];
  const Vec3f a = mesh.positions[t[0]];
  Vec3f ng = cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a);
  if (mesh.instanced) {
    ng = i.from_render.transposed_vector(ng);
  } else if (i.mirrored) {
    ng = -ng;
  }
  return normalize(ng);
}

bool Scene::has_attribute(uint32_t mesh, uint32_t id) const {
  const auto& attributes = meshes[mesh].attributes;
  return id < attributes.size() && attributes[id].channels > 0;
}

Vec4f Scene::attribute(const SurfacePoint& point, uint32_t id) const {
  if (point.mesh == kNoIndex || !has_attribute(point.mesh, id)) {
    return {};
  }
  const Mesh& mesh = meshes[point.mesh];
  const MeshAttribute& attribute = mesh.attributes[id];
  const auto channels = static_cast<size_t>(attribute.channels);
  const auto read = [&](uint32_t element) {
    const float* d = attribute.data.data() + static_cast<size_t>(element) * channels;
    switch (channels) {
      case 1:
        return Vec4f{d[0], d[0], d[0], 1.0f};
      case 2:
        return Vec4f{d[0], d[1], 0.0f, 1.0f};
      case 3:
        return Vec4f{d[0], d[1], d[2], 1.0f};
      default:
        return Vec4f{d[0], d[1], d[2], d[3]};
    }
  };
  if (attribute.domain == Domain::kFace) {
    return read(mesh.faces[point.triangle]);
  }
  const auto& e = attribute.domain == Domain::kPoint ? mesh.triangles[point.triangle]
                                                     : mesh.corners[point.triangle];
  return interpolate(read(e[0]), read(e[1]), read(e[2]), point.u, point.v);
}

Vec3f Scene::uv(const SurfacePoint& point) const {
  if (uv_attribute == kNoIndex || !has_attribute(point.mesh, uv_attribute)) {
    return {};
  }
  const Vec4f v = attribute(point, uv_attribute);
  return {v.x, v.y, 1.0f};
}

uint32_t Scene::material_of(uint32_t instance, uint32_t triangle) const {
  const Instance& i = instances[instance];
  const auto& slots = meshes[i.mesh].slots;
  const uint32_t slot = slots.empty() ? 0u : std::min<uint32_t>(slots[triangle], i.slot_count - 1u);
  return slot_materials[i.material_offset + slot];
}

float Scene::footprint(Vec3f p) const { return camera->footprint(p); }

}  // namespace vernier
