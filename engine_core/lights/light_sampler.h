// All lights of a scene: which to sample for a point, how, and with which densities.
//
// Lights are numbered: emissive triangles first, then lamps in the order of the description, then
// the environment. Emissive triangles and lamps at finite places are the leaves of a light tree;
// suns and the environment compete with the tree as a whole.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "embree/intersector.h"
#include "lights/emission_guide.h"
#include "lights/light_sample.h"
#include "math/vec.h"
#include "scene/description.h"
#include "scene/surface_point.h"

namespace vernier {

class Material;
class Scene;
struct Lamp;
struct LightTable;
struct ShapeSample;

class LightSampler {
 public:
  // `scene` is complete but for its light sampler, and outlives this. `lamp_shaders` has an entry
  // per lamp: the compiled graph that multiplies its emission, null where the lamp has none.
  // `environment_resolution` is the width of the environment's importance map, 0: chosen.
  // Appends to `warnings` what makes a light differ from its description.
  LightSampler(const Scene& scene, std::span<const LightDesc> lamps,
               std::vector<std::unique_ptr<Material>> lamp_shaders,
               std::vector<std::string>& warnings, int environment_resolution = 0);
  ~LightSampler();
  LightSampler(const LightSampler&) = delete;
  LightSampler& operator=(const LightSampler&) = delete;

  // Number of lights that can be sampled; 0: sample() always fails.
  uint32_t count() const;
  uint32_t emissive_triangle_count() const;
  // Whether there is more than one light to choose from at finite places.
  bool has_tree() const;
  // True where some lamp of finite size (or a sun or environment) can be met by rays of the kinds
  // in `mask`: otherwise for_each_lamp_hit (for_each_escape) has nothing to do.
  bool has_lamp_hits(uint32_t mask) const;
  bool has_escapes(uint32_t mask) const;

  // Chooses a light with u_select and a point on it with u. False where the choice has nothing for
  // this receiver: the sample's value is then zero. `out` is as LightSample's constructor leaves
  // it.
  bool sample(const Receiver& from, float u_select, Vec2f u, LightSample& out) const;
  // A point on the given light alone: the density is without the selection.
  bool sample_light(const Receiver& from, uint32_t light, Vec2f u, LightSample& out) const;

  // Solid-angle densities, selection included, with which sample() makes a direction that meets...
  // ...an emissive triangle, at `distance` under |cos| `abs_cos` at the triangle;
  float pdf_triangle(const Receiver& from, uint32_t instance, uint32_t triangle, Vec3f wi,
                     float distance, float abs_cos) const;
  // ...the environment;
  float pdf_environment(const Receiver& from, Vec3f wi) const;
  // ...light `light` (any but a delta light), at `distance` with its unit normal `n` there.
  float pdf_light(const Receiver& from, uint32_t light, Vec3f wi, float distance, Vec3f n) const;
  // Probability of the choice of `light`; over all lights these sum to 1, or to 0 where nothing
  // can light the receiver.
  float pdf_selection(const Receiver& from, uint32_t light) const;

  // Calls f(const LightHit&) for every lamp that the ray of unit direction crosses before t_max, in
  // no order. `mask` has the Visibility bit of the ray's kind. `from` is the receiver that sampled
  // the direction, `travelled` before the ray's origin (transparent surfaces lie between), or null
  // (camera rays, and after singular bounces). Lamps that face their receiver face the point
  // `travelled` before the origin.
  template <class F>
  void for_each_lamp_hit(const Receiver* from, const Ray& ray, uint32_t mask, float travelled,
                         F&& f) const {
    const Ray whole{from ? from->p : ray.o - ray.d * travelled, ray.d, travelled + ray.t_max};
    const Vec3f inverse = splat(1.0f) / ray.d;
    LightHit hit;
    for (uint32_t position = 0; next_lamp_hit(whole, inverse, travelled, mask, position, hit);) {
      hit.pdf = from ? pdf_lamp(*from, hit.light, ray.d, hit.t) : 0.0f;
      hit.t -= travelled;
      f(static_cast<const LightHit&>(hit));
    }
  }

  // The same for suns with an angle and for the environment, for a ray that leaves the scene.
  // `flags` and `depth` are what the world's shader may read.
  template <class F>
  void for_each_escape(const Receiver* from, Vec3f d, uint32_t mask, uint32_t flags,
                       const PathDepth& depth, F&& f) const {
    LightHit hit;
    for (uint32_t i = 0; next_escape(d, mask, flags, depth, i, hit);) {
      hit.pdf = from ? pdf_distant(*from, hit.light, d) : 0.0f;
      f(static_cast<const LightHit&>(hit));
    }
  }

  // Light from the environment against direction d; black where there is no world.
  Color environment(Vec3f d, uint32_t flags, const PathDepth& depth) const;

  // Chooses a light, then an origin and a direction. False where the sample has no radiance.
  bool sample_emission(const EmissionGuide& guide, float u_select, Vec2f u_position,
                       Vec2f u_direction, EmissionSample& out) const;
  // The guide that knows no more than the lights' power. Its weights are 0 for lights at which no
  // path may start: those that shine through walls, or on some kinds of surfaces only.
  const EmissionGuide& guide_by_power() const;
  // Number of lights at which no path may start though they shine.
  uint32_t uneven_count() const;
  // Densities with which sample_emission() by power makes origin p (normal n) and direction, given
  // `light`.
  EmissionPdf pdf_emission(uint32_t light, Vec3f p, Vec3f n, Vec3f direction) const;
  // Density, selection included, with which sample_emission() makes the ray that leaves `light` in
  // `direction` and arrives at p: over area across the ray and solid angle together, a measure that
  // is the same all along the ray (Veach 1997, section 4.1). Where the position is a delta: over
  // solid angle alone; where the direction is: over area alone. `direction` is one in which the
  // light shines at p. 0: paths do not start at this light.
  float pdf_emission_ray(const EmissionGuide& guide, uint32_t light, Vec3f p,
                         Vec3f direction) const;
  // Power of all lights that sample_emission() chooses from, watts (average of RGB).
  double total_power() const;

  // The light of a triangle, of the environment; kNoIndex where there is none.
  uint32_t light_of_triangle(uint32_t instance, uint32_t triangle) const;
  uint32_t light_of_environment() const;
  // Whether the world is a light of one radiance.
  bool has_uniform_environment() const;
  bool is_delta(uint32_t light) const;
  bool is_infinite(uint32_t light) const;
  // Whether the light is a point: sample_emission()'s delta_position.
  bool is_point(uint32_t light) const;
  // Whether it casts shadows and lights all that it reaches.
  bool is_plain(uint32_t light) const;
  // The middle of a light at a finite place, render space.
  Vec3f center(uint32_t light) const;
  // Whether scattered rays find the light by chance.
  bool is_hittable(uint32_t light) const;

 private:
  // The first lamp at or after `position` of the walk, which moves past it, that the ray meets
  // beyond t_min; false: no more.
  bool next_lamp_hit(const Ray& ray, Vec3f inverse_direction, float t_min, uint32_t mask,
                     uint32_t& position, LightHit& hit) const;
  bool next_escape(Vec3f d, uint32_t mask, uint32_t flags, const PathDepth& depth, uint32_t& i,
                   LightHit& hit) const;
  // Whether the world is a light of which nothing is worth a sample there.
  bool leaves_all_to(const Receiver& from) const;
  // Chooses a light: its number and probability; kNoIndex where nothing reaches the receiver.
  uint32_t choose(const Receiver& from, float u, float& probability) const;
  bool sample_triangle(uint32_t light, const Receiver& from, Vec2f u, LightSample& out) const;
  bool sample_lamp(uint32_t light, const Receiver& from, Vec2f u, LightSample& out) const;
  bool sample_environment(const Receiver& from, Vec2f u, LightSample& out) const;
  void emit_triangle(uint32_t light, Vec2f u_position, Vec2f u_direction, const Vec3f* given,
                     EmissionSample& out) const;
  Color lamp_radiance(const Lamp& lamp, const ShapeSample& shape) const;
  float pdf_lamp(const Receiver& from, uint32_t light, Vec3f wi, float distance) const;
  float pdf_distant(const Receiver& from, uint32_t light, Vec3f wi) const;

  std::unique_ptr<const LightTable> table_;
};

}  // namespace vernier
