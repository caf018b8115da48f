// Light as it leaves the lights, for light tracing and photon maps.

#include <cmath>

#include "lights/area_lamp.h"
#include "lights/lamp_coordinates.h"
#include "lights/light_sampler.h"
#include "lights/light_table.h"
#include "lights/light_table_build.h"
#include "lights/sphere_lamp.h"
#include "lights/sun_lamp.h"
#include "nodes/material.h"
#include "scene/scene.h"

namespace vernier {
namespace {

// 1 - cos of the cone about the axis into which a point or spot is sampled.
float emission_cone(const Lamp& lamp) {
  return lamp.kind == LightKind::kSpot ? lamp.one_minus_cos_spread : 2.0f;
}

// A spread area shines within a cone about its axis: sin^2 of the half angle.
float emission_sine2(const Lamp& lamp) {
  return lamp.spreads ? square(lamp.tan_half_spread) / (1.0f + square(lamp.tan_half_spread)) : 1.0f;
}

// Solid-angle density of the directions of points, spots and areas by themselves.
float direction_pdf(const Lamp& lamp, Vec3f d) {
  if (lamp.kind != LightKind::kArea) {
    // Beyond the cone that a spot's directions are drawn from.
    const bool beyond = lamp.kind == LightKind::kSpot &&
                        0.5f * length_squared(d - lamp.axis) > lamp.one_minus_cos_spread;
    return beyond ? 0.0f : uniform_cone_pdf(emission_cone(lamp));
  }
  const float cosine = dot(lamp.axis, d);
  const float sine2 = emission_sine2(lamp);
  const bool inside =
      cosine > 0.0f && (!lamp.spreads || length_squared(cross(lamp.axis, d)) <= sine2);
  return inside ? cosine * kInvPi / sine2 : 0.0f;
}

// A spherical lamp's direction is drawn first, then a point of the disk across it, which is moved
// to the sphere: on it that is cos / (pi r^2) by area. Of the product of the densities the
// position's is given as 1 / (4 pi r^2) and the direction's as the rest.
EmissionPdf sphere_pdf(const Lamp& lamp, float cosine, float direction) {
  if (lamp.delta) {
    return {1.0f, direction};
  }
  const float disk = kPi * square(lamp.radius);
  return lamp.soft ? EmissionPdf{1.0f / disk, direction}
                   : EmissionPdf{0.25f / disk, 4.0f * cosine * direction};
}

// Lines through a soft lamp at distance b < r from its centre light what is farther along them than
// b^2 / sqrt(r^2 - b^2): from there the line meets the disk of radius r that faces the receiver.
// For a receiver at distance t along it, it does so b^2 / t on the other side.
float soft_lit_from(float b2, float r2) {
  const float rest = r2 - b2;
  return rest > 0.0f ? b2 / std::sqrt(rest) : kInfinity;
}

// Where a direction is given, it takes the place of the lamp's own choice.
void emit_sphere(const Lamp& lamp, Vec2f u_position, Vec2f u_direction, const Vec3f* given,
                 EmissionSample& out, ShapeSample& shape) {
  out.direction = given ? *given
                        : normalize(Frame(lamp.axis).to_world(
                              square_to_uniform_cone(u_direction, emission_cone(lamp))));
  out.p = lamp.center;
  out.n = out.direction;
  out.delta_position = lamp.delta;
  if (!lamp.delta) {
    const Vec2f disk = square_to_disk(u_position);
    const Frame across(out.direction);
    const float rho2 = disk.x * disk.x + disk.y * disk.y;
    const Vec3f offset = across.s * disk.x + across.t * disk.y;
    if (lamp.soft) {
      out.p = lamp.center + offset * lamp.radius;
      out.lit_from = lamp.radius * soft_lit_from(rho2, 1.0f);
      out.behind = square(lamp.radius) * rho2;
    } else {
      out.n = normalize(offset + out.direction * safe_sqrt(1.0f - rho2));
      out.p = lamp.center + out.n * lamp.radius;
      out.cosine = safe_sqrt(1.0f - rho2);
    }
  }
  shape.factor = lamp.kind == LightKind::kSpot ? spot_attenuation(lamp, out.direction) : 1.0f;
}

void emit_area(const Lamp& lamp, Vec2f u_position, Vec2f u_direction, const Vec3f* given,
               EmissionSample& out, ShapeSample& shape) {
  const Vec2f q = lamp.ellipse ? square_to_disk(u_position)
                               : Vec2f{2.0f * u_position.x - 1.0f, 2.0f * u_position.y - 1.0f};
  out.p = lamp.center + lamp.axis_u * (q.x * lamp.half_u) + lamp.axis_v * (q.y * lamp.half_v);
  out.n = lamp.axis;
  out.delta_direction = lamp.delta;
  if (lamp.delta) {
    out.direction = lamp.axis;
    shape.factor = 1.0f;
    return;
  }
  if (given) {
    out.direction = *given;
    out.cosine = dot(lamp.axis, *given);
  } else {
    const Vec2f d = square_to_disk(u_direction) * std::sqrt(emission_sine2(lamp));
    const Vec3f local{d.x, d.y, safe_sqrt(1.0f - d.x * d.x - d.y * d.y)};
    out.direction = normalize(Frame(lamp.axis).to_world(local));
    out.cosine = local.z;
  }
  shape.factor = area_lamp_factor(lamp, -out.direction);
}

float disk_density(float radius) { return bounded_density(kInvPi / radius / radius); }

// Density, over area across a distant light's rays, of one that passes the guide's centre at
// distance rho, and at q of its square where there is a `place`.
float aimed_density(const EmissionGuide& guide, const PlaceGuide* place, Vec2f q, float rho) {
  float density = 0.0f;
  if (rho <= guide.radius) {
    density = guide.share * (place ? 1.0f - place->share : 1.0f) * disk_density(guide.radius);
  } else if (rho <= guide.reach) {
    density =
        (1.0f - guide.share) * 0.5f * disk_density(rho) / std::log(guide.reach / guide.radius);
  }
  if (place) {
    density +=
        guide.share * place->share * bounded_density(place->pdf(q) / guide.radius / guide.radius);
  }
  return density;
}

// The same for the ray of `light` through p along d.
float afar_density(const LightTable& table, const EmissionGuide& guide, uint32_t light, Vec3f p,
                   Vec3f d) {
  if (!(guide.share > 0.0f)) {
    return disk_density(table.radius);
  }
  const PlaceGuide* place = guide.place(light);
  return aimed_density(guide, place, place ? guide.place_of(p, d) : Vec2f{},
                       length(cross(p - guide.center, d)));
}

// A ray along d, from before the bounding sphere. Returns its density over the area across it.
float emit_from_afar(const LightTable& table, const EmissionGuide& guide, Vec2f u, Vec3f d,
                     EmissionSample& out) {
  Vec3f center = table.center;
  Vec2f offset;
  float density = disk_density(table.radius);
  if (guide.share > 0.0f) {
    center = guide.center;
    const PlaceGuide* place = guide.place(out.light);
    const float by_place = place ? guide.share * place->share : 0.0f;
    Vec2f q;
    float rho;
    if (u.x < by_place) {
      q = place->sample({u.x / by_place, u.y});
      rho = guide.radius * std::sqrt(q.x * q.x + q.y * q.y);
    } else if (u.x < guide.share) {
      q = square_to_disk({(u.x - by_place) / (guide.share - by_place), u.y});
      rho = std::min(guide.radius * std::sqrt(q.x * q.x + q.y * q.y), guide.radius);
    } else {
      const float outward = (u.x - guide.share) / (1.0f - guide.share);
      rho = std::max(guide.radius * std::pow(guide.reach / guide.radius, outward),
                     std::nextafter(guide.radius, kInfinity));
      q = Vec2f{std::cos(kTwoPi * u.y), std::sin(kTwoPi * u.y)} * (rho / guide.radius);
    }
    offset = q * guide.radius;
    density = aimed_density(guide, place, q, rho);
  } else {
    offset = square_to_disk(u) * table.radius;
  }
  const Frame across(d);
  out.direction = d;
  out.n = d;
  out.infinite = true;
  const float before = table.radius + dot(center - table.center, d);
  out.p = center + across.s * offset.x + across.t * offset.y - d * before;
  return density;
}

// `direction` is the density of the direction d, where the lamp has one.
EmissionPdf lamp_emission_pdf(const LightTable& table, const Lamp& lamp, Vec3f n, Vec3f d,
                              float direction) {
  switch (lamp.kind) {
    case LightKind::kPoint:
    case LightKind::kSpot:
      return sphere_pdf(lamp, lamp.soft ? 1.0f : std::max(dot(n, d), 0.0f), direction);
    case LightKind::kArea:
      return {1.0f / lamp.area, lamp.delta ? 1.0f : direction};
    case LightKind::kSun:
      return {disk_density(table.radius), lamp.delta               ? 1.0f
                                          : sun_may_draw(lamp, -d) ? pdf_sun(lamp)
                                                                   : 0.0f};
  }
  return {};
}

// Density of a lamp's rays, by area across them and solid angle (where one of the two is a delta:
// by the other alone). `direction` as above. The cosine at a sphere cancels.
float lamp_ray_pdf(const LightTable& table, const EmissionGuide& guide, uint32_t light, Vec3f p,
                   Vec3f d, float direction) {
  const Lamp& lamp = table.lamp(light);
  switch (lamp.kind) {
    case LightKind::kPoint:
    case LightKind::kSpot: {
      if (lamp.delta) {
        return direction;
      }
      // A sphere emits outward only.
      const bool outside = lamp.soft || length_squared(p - lamp.center) > square(lamp.radius);
      return outside ? direction * bounded_density(kInvPi / square(lamp.radius)) : 0.0f;
    }
    case LightKind::kArea: {
      const float cosine = dot(lamp.axis, d);
      return lamp.delta ? 1.0f / lamp.area
                        : (cosine > 0.0f ? direction / (cosine * lamp.area) : 0.0f);
    }
    case LightKind::kSun:
      return afar_density(table, guide, light, p, d) * (lamp.delta ? 1.0f : pdf_sun(lamp));
  }
  return 0.0f;
}

// Density of a direction, of which the guide makes a part.
float guided(const DirectionGuide* guide, float by_itself, Vec3f d) {
  return guide ? lerp(by_itself, guide->pdf(d), guide->share) : by_itself;
}

}  // namespace

double LightSampler::total_power() const { return table_->total_power; }

const EmissionGuide& LightSampler::guide_by_power() const { return table_->by_power; }
uint32_t LightSampler::uneven_count() const { return table_->uneven; }

EmissionPdf LightSampler::pdf_emission(uint32_t light, Vec3f p, Vec3f n, Vec3f direction) const {
  static_cast<void>(p);
  const LightTable& table = *table_;
  if (table.is_triangle(light)) {
    // Either side with probability one half.
    return {bounded_density(1.0f / table.triangles[light].area),
            0.5f * std::abs(dot(n, direction)) * kInvPi};
  }
  if (table.is_environment(light)) {
    return {disk_density(table.radius), table.environment.pdf_direction(-direction)};
  }
  const Lamp& lamp = table.lamp(light);
  return lamp_emission_pdf(table, lamp, n, direction, direction_pdf(lamp, direction));
}

float LightSampler::pdf_emission_ray(const EmissionGuide& guide, uint32_t light, Vec3f p,
                                     Vec3f direction) const {
  const LightTable& table = *table_;
  const float selection = guide.lights.probability(light);
  if (!(selection > 0.0f)) {
    return 0.0f;
  }
  const DirectionGuide* aim = guide.direction(light);
  if (table.is_triangle(light)) {
    const TriangleLight& triangle = table.triangles[light];
    const float cosine = std::abs(dot(triangle.n, direction));
    const float density =
        aim ? guided(aim, 0.5f * kInvPi * cosine, direction) / std::max(cosine, kUnitRoundoff)
            : 0.5f * kInvPi;
    return selection * density * bounded_density(1.0f / triangle.area);
  }
  if (table.is_environment(light)) {
    return selection * afar_density(table, guide, light, p, direction) *
           table.environment.pdf_direction(-direction);
  }
  const Lamp& lamp = table.lamp(light);
  return selection * lamp_ray_pdf(table, guide, light, p, direction,
                                  guided(aim, direction_pdf(lamp, direction), direction));
}

bool LightSampler::sample_emission(const EmissionGuide& guide, float u_select, Vec2f u_position,
                                   Vec2f u_direction, EmissionSample& out) const {
  const LightTable& table = *table_;
  if (guide.lights.size() == 0) {
    return false;
  }
  out = EmissionSample{};
  out.light = guide.lights.sample(u_select);
  out.pdf_selection = guide.lights.probability(out.light);
  const DirectionGuide* aim = guide.direction(out.light);
  Vec3f aimed;
  const Vec3f* given = nullptr;
  if (aim) {
    if (u_direction.x < aim->share) {
      u_direction.x /= aim->share;
      aimed = aim->sample(u_direction);
      given = &aimed;
    } else {
      u_direction.x =
          std::min((u_direction.x - aim->share) / (1.0f - aim->share), kOneMinusEpsilon);
    }
  }
  EmissionPdf pdf;
  if (table.is_triangle(out.light)) {
    emit_triangle(out.light, u_position, u_direction, given, out);
    pdf = pdf_emission(out.light, out.p, out.n, out.direction);
    pdf.direction = guided(aim, pdf.direction, out.direction);
  } else if (table.is_environment(out.light)) {
    const Vec3f d = -table.environment.sample_direction(u_direction, pdf.direction);
    pdf.position = emit_from_afar(table, guide, u_position, d, out);
    out.radiance = environment(-out.direction, 0, PathDepth{});
    out.visibility = table.scene->world_visibility;
  } else {
    const Lamp& lamp = table.lamp(out.light);
    ShapeSample shape;
    float afar = 0.0f;
    switch (lamp.kind) {
      case LightKind::kPoint:
      case LightKind::kSpot:
        emit_sphere(lamp, u_position, u_direction, given, out, shape);
        break;
      case LightKind::kArea:
        emit_area(lamp, u_position, u_direction, given, out, shape);
        break;
      case LightKind::kSun:
        sample_sun(lamp, u_direction, shape);
        out.delta_direction = lamp.delta;
        afar = emit_from_afar(table, guide, u_position, -shape.wi, out);
        break;
    }
    shape.wi = -out.direction;
    shape.p = out.p;
    shape.n = out.n;
    out.radiance = shape.factor > 0.0f ? lamp_radiance(lamp, shape) : Color{};
    out.p_error = gamma(8) * (abs(lamp.center) + abs(out.p - lamp.center));
    out.visibility = lamp.visibility;
    out.cast_shadow = lamp.cast_shadow;
    pdf = lamp_emission_pdf(table, lamp, out.n, out.direction,
                            guided(aim, direction_pdf(lamp, out.direction), out.direction));
    if (out.infinite) {
      pdf.position = afar;
    }
  }
  out.pdf_position = pdf.position;
  out.pdf_direction = pdf.direction;
  return out.pdf_position > 0.0f && out.pdf_direction > 0.0f && out.cosine > 0.0f &&
         !is_black(out.radiance);
}

void LightSampler::emit_triangle(uint32_t light, Vec2f u_position, Vec2f u_direction,
                                 const Vec3f* given, EmissionSample& out) const {
  const TriangleLight& triangle = table_->triangles[light];
  const Vec2f b = square_to_triangle(u_position);
  if (given) {
    const float side = dot(triangle.n, *given);
    out.n = side < 0.0f ? -triangle.n : triangle.n;
    out.direction = *given;
    out.cosine = std::abs(side);
  } else {
    // The lower half of u.x is one side, the upper the other.
    const bool back = u_direction.x >= 0.5f;
    u_direction.x = std::min(2.0f * u_direction.x - (back ? 1.0f : 0.0f), kOneMinusEpsilon);
    out.n = back ? -triangle.n : triangle.n;
    const Vec3f local = square_to_cosine_hemisphere(u_direction);
    out.direction = normalize(Frame(out.n).to_world(local));
    out.cosine = local.z;
  }
  out.p = triangle.v0 + triangle.e1 * b.x + triangle.e2 * b.y;
  out.p_error = gamma(8) * (abs(triangle.v0) + abs(triangle.e1) + abs(triangle.e2));
  out.instance = triangle.instance;
  out.triangle = triangle.triangle;
  const TriangleEmitter& emitter = table_->emitters[triangle.emitter];
  out.visibility = emitter.visibility;
  if (emitter.constant) {
    out.radiance = emitter.radiance;
    return;
  }
  // The point as a viewer at one unit along the direction would meet it.
  SurfacePoint point =
      table_->scene->surface_point(Ray{out.p + out.direction, -out.direction, kInfinity},
                                   Hit{1.0f, b.x, b.y, triangle.instance, triangle.triangle});
  point.ray_flags = 0;
  out.radiance = bounded_radiance(emitter.material->emission(point));
}

}  // namespace vernier
