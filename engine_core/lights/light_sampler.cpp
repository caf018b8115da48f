#include "lights/light_sampler.h"

#include <cmath>

#include "lights/area_lamp.h"
#include "lights/first_choice.h"
#include "lights/lamp_coordinates.h"
#include "lights/light_table.h"
#include "lights/light_table_build.h"
#include "lights/sphere_lamp.h"
#include "lights/sun_lamp.h"
#include "math/distribution.h"
#include "nodes/material.h"
#include "scene/scene.h"

namespace vernier {
LightSampler::LightSampler(const Scene& scene, std::span<const LightDesc> lamps,
                           std::vector<std::unique_ptr<Material>> lamp_shaders,
                           std::vector<std::string>& warnings, int environment_resolution)
    : table_(build_light_table(scene, lamps, std::move(lamp_shaders), warnings,
                               environment_resolution)) {}

LightSampler::~LightSampler() = default;

uint32_t LightSampler::count() const { return table_->count(); }

uint32_t LightSampler::emissive_triangle_count() const { return table_->first_lamp(); }

bool LightSampler::has_uniform_environment() const {
  return table_->has_environment && table_->environment.is_uniform();
}

bool LightSampler::leaves_all_to(const Receiver& from) const {
  return table_->has_environment && table_->environment.leaves_all_to(from);
}

bool LightSampler::has_tree() const { return count() > table_->distant.size() + 1; }

bool LightSampler::has_lamp_hits(uint32_t mask) const {
  return (table_->visible_lamps & mask) != 0;
}

bool LightSampler::has_escapes(uint32_t mask) const {
  const Material* world = table_->scene->world.get();
  const bool sees_world =
      world && world->traits().is_emissive && (table_->scene->world_visibility & mask) != 0;
  return sees_world || (table_->visible_suns & mask) != 0;
}

uint32_t LightSampler::light_of_triangle(uint32_t instance, uint32_t triangle) const {
  return table_->triangle_index.find(instance, triangle);
}

uint32_t LightSampler::light_of_environment() const {
  return table_->has_environment ? table_->environment_light() : kNoIndex;
}

bool LightSampler::is_delta(uint32_t light) const {
  return !table_->is_triangle(light) && !table_->is_environment(light) && table_->lamp(light).delta;
}

bool LightSampler::is_infinite(uint32_t light) const {
  return !table_->is_triangle(light) &&
         (table_->is_environment(light) || table_->lamp(light).kind == LightKind::kSun);
}

bool LightSampler::is_point(uint32_t light) const {
  if (table_->is_triangle(light) || table_->is_environment(light)) {
    return false;
  }
  const Lamp& lamp = table_->lamp(light);
  return lamp.delta && (lamp.kind == LightKind::kPoint || lamp.kind == LightKind::kSpot);
}

bool LightSampler::is_plain(uint32_t light) const {
  const auto whole = [](uint32_t visibility) {
    return (visibility & kVisibleScattered) == kVisibleScattered;
  };
  if (table_->is_triangle(light)) {
    return whole(table_->emitter(light).visibility);
  }
  if (table_->is_environment(light)) {
    return whole(table_->scene->world_visibility | kVisibleShadow);
  }
  return table_->lamp(light).cast_shadow && whole(table_->lamp(light).visibility | kVisibleShadow);
}

Vec3f LightSampler::center(uint32_t light) const {
  if (table_->is_triangle(light)) {
    const TriangleLight& triangle = table_->triangles[light];
    return triangle.v0 + (triangle.e1 + triangle.e2) * (1.0f / 3.0f);
  }
  return table_->lamp(light).center;
}

bool LightSampler::is_hittable(uint32_t light) const {
  return table_->is_triangle(light) || table_->is_environment(light) ||
         table_->lamp(light).hittable;
}

uint32_t LightSampler::choose(const Receiver& from, float u, float& probability) const {
  const LightTable& table = *table_;
  if (table.count() == 1) {
    probability = 1.0f;
    return leaves_all_to(from) ? kNoIndex : 0;
  }
  if (table.distant.empty()) {
    const LightTree::Query query(from);
    const uint32_t light =
        table.tree.sample(query, table.tree.choose_first(query), extend_bits(u), probability);
    return probability > 0.0f ? light : kNoIndex;
  }
  const FirstChoice first(table, from);
  if (!first.any()) {
    return kNoIndex;
  }
  double rest = extend_bits(u);
  for (size_t i = 0; i < table.distant.size(); ++i) {
    const float p = first.probability_of(i);
    // The last alternative takes what rounding leaves.
    const bool last = !first.has_tree() && i + 1 == table.distant.size();
    if (p > 0.0f && (rest < static_cast<double>(p) || last)) {
      probability = p;
      return table.distant[i];
    }
    rest -= static_cast<double>(p);
  }
  const float p = first.probability_of_tree();
  if (!(p > 0.0f)) {
    return kNoIndex;
  }
  const double u_tree = rest / static_cast<double>(p);
  const uint32_t light =
      first.sample_tree(u_tree < 1.0 ? u_tree : 0x1.fffffffffffffp-1, probability);
  probability *= p;
  return probability > 0.0f ? light : kNoIndex;
}

float LightSampler::pdf_selection(const Receiver& from, uint32_t light) const {
  const LightTable& table = *table_;
  if (table.count() == 1) {
    return leaves_all_to(from) ? 0.0f : 1.0f;
  }
  if (table.distant.empty()) {
    const LightTree::Query query(from);
    return table.tree.pdf(query, table.tree.choose_first(query), light);
  }
  const FirstChoice first(table, from);
  for (size_t i = 0; i < table.distant.size(); ++i) {
    if (table.distant[i] == light) {
      return first.probability_of(i);
    }
  }
  const float p = first.probability_of_tree();
  return p > 0.0f ? p * first.pdf_tree(light) : 0.0f;
}

bool LightSampler::sample(const Receiver& from, float u_select, Vec2f u, LightSample& out) const {
  const LightTable& table = *table_;
  if (table.count() == 0) {
    return false;
  }
  float selection = 0.0f;
  const uint32_t light = choose(from, u_select, selection);
  if (light == kNoIndex || !sample_light(from, light, u, out)) {
    return false;
  }
  out.pdf_selection = selection;
  out.pdf *= selection;
  return out.pdf > 0.0f;
}

bool LightSampler::sample_light(const Receiver& from, uint32_t light, Vec2f u,
                                LightSample& out) const {
  out.light = light;
  out.pdf_selection = 1.0f;
  const bool found = table_->is_triangle(light)      ? sample_triangle(light, from, u, out)
                     : table_->is_environment(light) ? sample_environment(from, u, out)
                                                     : sample_lamp(light, from, u, out);
  return found && !is_black(out.radiance) && out.pdf > 0.0f;
}

bool LightSampler::sample_triangle(uint32_t light, const Receiver& from, Vec2f u,
                                   LightSample& out) const {
  const TriangleLight& triangle = table_->triangles[light];
  TriangleSample s;
  if (!sample_triangle_light(triangle, from.p, u, s)) {
    return false;
  }
  out.wi = s.shape.wi;
  out.distance = s.shape.distance;
  out.p = s.shape.p;
  out.p_error = gamma(8) * (abs(triangle.v0) + abs(triangle.e1) + abs(triangle.e2));
  out.n = s.shape.n;
  out.pdf = s.shape.pdf;
  out.instance = triangle.instance;
  out.triangle = triangle.triangle;
  out.hittable = true;
  const TriangleEmitter& emitter = table_->emitters[triangle.emitter];
  out.visibility = emitter.visibility;
  if (emitter.constant) {
    out.radiance = emitter.radiance;
  } else {
    SurfacePoint point = table_->scene->surface_point(
        Ray{from.p, out.wi, kInfinity},
        Hit{out.distance, s.b1, s.b2, triangle.instance, triangle.triangle});
    point.ray_flags = 0;
    out.radiance = bounded_radiance(emitter.material->emission(point));
  }
  return true;
}

Color LightSampler::lamp_radiance(const Lamp& lamp, const ShapeSample& shape) const {
  if (!lamp.shader) {
    return bounded_radiance(lamp.radiance * shape.factor);
  }
  SurfacePoint point;
  point.scene = table_->scene;
  point.p = shape.p;
  point.ng = point.ns = shape.n;
  point.wo = -shape.wi;
  const Vec2f uv = lamp_coordinates(lamp, shape);
  point.u = uv.x;
  point.v = uv.y;
  point.ray_length = lamp.kind == LightKind::kSun ? 0.0f : shape.distance;
  point.ray_flags = 0;  // as Cycles: a lamp's shader knows no kind of ray
  return bounded_radiance(lamp.radiance * lamp.shader->emission(point) * shape.factor);
}

bool LightSampler::sample_lamp(uint32_t light, const Receiver& from, Vec2f u,
                               LightSample& out) const {
  const Lamp& lamp = table_->lamp(light);
  ShapeSample s;
  switch (lamp.kind) {
    case LightKind::kPoint:
    case LightKind::kSpot:
      if (!sample_sphere_lamp(lamp, from, u, s)) {
        return false;
      }
      break;
    case LightKind::kArea:
      if (!sample_area_lamp(lamp, from, u, s)) {
        return false;
      }
      break;
    case LightKind::kSun:
      if (!sample_sun(lamp, u, s)) {
        return false;
      }
      break;
  }
  out.wi = s.wi;
  out.distance = s.distance;
  out.radiance = lamp_radiance(lamp, s);
  out.pdf = s.pdf;
  out.p = s.p;
  out.p_error = gamma(8) * (abs(lamp.center) + abs(s.p - lamp.center) + abs(from.p));
  out.n = s.n;
  out.visibility = lamp.visibility;
  out.delta = lamp.delta;
  out.hittable = lamp.hittable;
  out.cast_shadow = lamp.cast_shadow;
  return true;
}

bool LightSampler::sample_environment(const Receiver& from, Vec2f u, LightSample& out) const {
  out.wi = table_->environment.sample(from, u, out.pdf);
  if (!(out.pdf > 0.0f)) {
    return false;
  }
  out.distance = kInfinity;
  out.n = -out.wi;
  out.radiance = environment(out.wi, 0, PathDepth{});
  out.visibility = table_->scene->world_visibility;
  out.hittable = true;
  return true;
}

float LightSampler::pdf_triangle(const Receiver& from, uint32_t instance, uint32_t triangle,
                                 Vec3f wi, float distance, float abs_cos) const {
  static_cast<void>(wi);
  const uint32_t light = light_of_triangle(instance, triangle);
  if (light == kNoIndex) {
    return 0.0f;
  }
  const float selection = pdf_selection(from, light);
  return selection > 0.0f
             ? selection * pdf_triangle_light(table_->triangles[light], from.p, distance, abs_cos)
             : 0.0f;
}

float LightSampler::pdf_environment(const Receiver& from, Vec3f wi) const {
  return table_->has_environment ? pdf_distant(from, table_->environment_light(), wi) : 0.0f;
}

float LightSampler::pdf_light(const Receiver& from, uint32_t light, Vec3f wi, float distance,
                              Vec3f n) const {
  if (table_->is_triangle(light)) {
    return pdf_selection(from, light) *
           pdf_triangle_light(table_->triangles[light], from.p, distance, std::abs(dot(n, wi)));
  }
  return is_infinite(light) ? pdf_distant(from, light, wi) : pdf_lamp(from, light, wi, distance);
}

float LightSampler::pdf_lamp(const Receiver& from, uint32_t light, Vec3f wi, float distance) const {
  const Lamp& lamp = table_->lamp(light);
  const float selection = lamp.delta ? 0.0f : pdf_selection(from, light);
  if (!(selection > 0.0f)) {
    return 0.0f;
  }
  return selection * (lamp.kind == LightKind::kArea
                          ? pdf_area_lamp(lamp, from.p, wi, distance)
                          : pdf_sphere_lamp(lamp, from, view_sphere(lamp, from.p), wi));
}

float LightSampler::pdf_distant(const Receiver& from, uint32_t light, Vec3f wi) const {
  if (table_->is_environment(light)) {
    return table_->has_environment ? pdf_selection(from, light) * table_->environment.pdf(from, wi)
                                   : 0.0f;
  }
  const Lamp& lamp = table_->lamp(light);
  return sun_may_draw(lamp, wi) ? pdf_selection(from, light) * pdf_sun(lamp) : 0.0f;
}

Color LightSampler::environment(Vec3f d, uint32_t flags, const PathDepth& depth) const {
  const Scene& scene = *table_->scene;
  return scene.world && scene.world->traits().is_emissive
             ? environment_radiance(scene, d, flags, depth)
             : Color{};
}

bool LightSampler::next_lamp_hit(const Ray& ray, Vec3f inverse_direction, float t_min,
                                 uint32_t mask, uint32_t& position, LightHit& hit) const {
  const LightTable& table = *table_;
  for (uint32_t number = table.lamp_bvh.next(ray, inverse_direction, position); number != kNoIndex;
       number = table.lamp_bvh.next(ray, inverse_direction, position)) {
    const Lamp& lamp = table.lamps[number];
    if ((lamp.visibility & mask) == 0 || (!lamp.hittable && (mask & kVisibleCamera) == 0)) {
      continue;
    }
    ShapeSample s;
    s.wi = ray.d;
    const SphereView view = lamp.kind == LightKind::kArea ? SphereView{} : view_sphere(lamp, ray.o);
    s.distance = lamp.kind == LightKind::kArea ? intersect_area_lamp(lamp, ray.o, ray.d)
                                               : intersect_sphere(lamp, view, ray.o, ray.d);
    if (!(s.distance > t_min) || !(s.distance < ray.t_max)) {
      continue;
    }
    s.p = ray.o + ray.d * s.distance;
    if (lamp.kind == LightKind::kArea) {
      s.factor = area_lamp_factor(lamp, ray.d);
      s.n = lamp.axis;
    } else {
      s.factor = sphere_lamp_factor(lamp, view, ray.d);
      const Vec3f outward = normalize(s.p - lamp.center);
      s.n = lamp.soft ? -view.to_center : (view.inside ? -outward : outward);
    }
    if (!(s.factor > 0.0f)) {
      continue;
    }
    hit.light = table.first_lamp() + number;
    hit.t = s.distance;
    hit.radiance = lamp_radiance(lamp, s);
    return true;
  }
  return false;
}

bool LightSampler::next_escape(Vec3f d, uint32_t mask, uint32_t flags, const PathDepth& depth,
                               uint32_t& i, LightHit& hit) const {
  const LightTable& table = *table_;
  hit.t = kInfinity;
  while (i < table.lamps.size()) {
    const uint32_t light = table.first_lamp() + i;
    const Lamp& lamp = table.lamps[i++];
    if (lamp.kind != LightKind::kSun || !lamp.hittable || (lamp.visibility & mask) == 0 ||
        !sun_contains(lamp, d)) {
      continue;
    }
    ShapeSample s;
    s.wi = d;
    s.distance = kInfinity;
    s.n = -d;
    s.factor = 1.0f;
    hit.light = light;
    hit.radiance = lamp_radiance(lamp, s);
    return true;
  }
  if (i == table.lamps.size()) {
    ++i;
    const Material* world = table.scene->world.get();
    if (world && world->traits().is_emissive && (table.scene->world_visibility & mask) != 0) {
      // Where nothing of it was found to sample, no other technique knows it.
      hit.light = table.has_environment ? table.environment_light() : kNoIndex;
      hit.radiance = environment_radiance(*table.scene, d, flags, depth);
      return true;
    }
  }
  return false;
}

}  // namespace vernier
