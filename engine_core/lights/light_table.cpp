#include "lights/light_table.h"

#include <cmath>
#include <map>
#include <utility>

#include "lights/light_table_build.h"
#include "nodes/material.h"
#include "scene/scene.h"

namespace vernier {
namespace {

// Cells along a side of the environment's map: 0.8 and 0.2 degrees.
constexpr int kLeastResolution = 256;
constexpr int kLargestResolution = 1024;
constexpr double kPiDouble = 3.14159265358979323846;

// Numbers what shines as the same material does and is seen alike.
class Emitters {
 public:
  explicit Emitters(std::vector<TriangleEmitter>& emitters) : emitters_(emitters) {}

  uint32_t number_of(const Material& material, uint32_t visibility) {
    const auto next = static_cast<uint32_t>(emitters_.size());
    const auto [at, is_new] = numbers_.try_emplace({&material, visibility}, next);
    if (is_new) {
      const MaterialTraits& traits = material.traits();
      emitters_.push_back({&material, visibility, traits.emission_constant,
                           bounded_radiance(traits.average_emission)});
    }
    return at->second;
  }

 private:
  std::vector<TriangleEmitter>& emitters_;
  std::map<std::pair<const Material*, uint32_t>, uint32_t> numbers_;
};

void add_triangles(const Scene& scene, LightTable& table) {
  Emitters emitters(table.emitters);
  for (uint32_t i = 0; i < scene.instances.size(); ++i) {
    const Mesh& mesh = scene.meshes[scene.instances[i].mesh];
    const auto count = static_cast<uint32_t>(mesh.triangles.size());
    bool any = false;
    for (uint32_t slot = 0; slot < scene.instances[i].slot_count; ++slot) {
      const uint32_t material = scene.slot_materials[scene.instances[i].material_offset + slot];
      any = any || scene.materials[material]->traits().is_emissive;
    }
    if (!any) {
      table.triangle_index.add_dark_instance();
      continue;
    }
    std::vector<bool> emissive(count);
    for (uint32_t t = 0; t < count; ++t) {
      const Material& material = *scene.materials[scene.material_of(i, t)];
      const MaterialTraits& traits = material.traits();
      if (!traits.is_emissive || (traits.emission_constant && is_black(traits.average_emission))) {
        continue;
      }
      const std::array<Vec3f, 3> p = scene.triangle(i, t);
      TriangleLight light{p[0], p[1] - p[0], p[2] - p[0], {}, 0.0f, i, t};
      measure(light);
      if (light.area > 0.0f) {
        light.emitter = emitters.number_of(material, scene.instances[i].visibility);
        emissive[t] = true;
        table.triangles.push_back(light);
      }
    }
    table.triangle_index.add_instance(emissive);
  }
}

// Smallest box of what a lamp shines from, and its cone.
LightBounds lamp_bounds(const Lamp& lamp) {
  LightBounds b;
  Vec3f half = splat(lamp.radius);
  b.axis = lamp.axis;
  switch (lamp.kind) {
    case LightKind::kSun:
    case LightKind::kPoint:
      b.angle_o = kPi;
      break;
    case LightKind::kSpot:
      // 1 - cos is 2 sin^2 of half the angle.
      b.angle_e = 2.0f * std::asin(std::sqrt(std::min(0.5f * lamp.one_minus_cos_spread, 1.0f)));
      break;
    case LightKind::kArea:
      half = abs(lamp.axis_u) * lamp.half_u + abs(lamp.axis_v) * lamp.half_v;
      if (lamp.delta) {
        b.angle_e = 0.0f;
      } else if (lamp.spreads) {
        b.angle_e = std::atan(lamp.tan_half_spread);
      }
      break;
  }
  b.lower = lamp.center - half;
  b.upper = lamp.center + half;
  return b;
}

// Watts per steradian along the brightest direction. A spot's is that of a point that is as bright
// all around, an area's that of its front.
double lamp_intensity(const Lamp& lamp) {
  const double power = static_cast<double>(lamp.power);
  switch (lamp.kind) {
    case LightKind::kSun:
      return 0.0;
    case LightKind::kPoint:
      return power / (4.0 * kPiDouble);
    case LightKind::kSpot:
      return power / (kPiDouble * static_cast<double>(lamp.one_minus_cos_spread));
    case LightKind::kArea: {
      // Parallel rays irradiate alike at any distance: as if from as far as the lamp is wide.
      const double narrow = lamp.delta ? kPiDouble : 1.0;
      const double grid = lamp.spreads && !lamp.delta
                              ? static_cast<double>(lamp.tan_half_spread) *
                                    static_cast<double>(lamp.normalize_spread)
                              : 1.0;
      return power / kPiDouble * narrow * grid;
    }
  }
  return 0.0;
}

LightBounds triangle_bounds(const TriangleLight& light) {
  LightBounds b;
  const Vec3f v1 = light.v0 + light.e1;
  const Vec3f v2 = light.v0 + light.e2;
  b.lower = min(light.v0, min(v1, v2));
  b.upper = max(light.v0, max(v1, v2));
  b.axis = normalize(cross(light.e1, light.e2));
  b.two_sided = true;
  return b;
}

double triangle_intensity(const LightTable& table, uint32_t number) {
  const TriangleLight& light = table.triangles[number];
  const MaterialTraits& traits = table.emitter(number).material->traits();
  const double estimate = static_cast<double>(average(abs(traits.average_emission)));
  // An estimate of zero does not make the light dark.
  return static_cast<double>(light.area) * (estimate > 0.0 ? estimate : 1.0);
}

// A map of the world. With as many cells to a side as a panorama is wide a cell is half as wide as
// a pixel at the horizon, and its middle shows all that is there. Otherwise there are four points
// to a cell: what is smaller than a cell, such as a sun, is less often missed.
EnvironmentMap map_environment(const Scene& scene, int resolution) {
  const int width = scene.world->traits().emission_image_width;
  if (resolution == 0) {
    resolution = std::clamp(width, kLeastResolution, kLargestResolution);
  }
  return EnvironmentMap(resolution, width > 0 && width <= resolution ? 1 : 2,
                        !scene.world->traits().path_dependent,
                        [&](Vec3f d) { return environment_radiance(scene, d, 0, PathDepth{}); });
}

void choose_environment(const Scene& scene, int resolution, LightTable& table) {
  if (!scene.world || !scene.world->traits().is_emissive) {
    return;
  }
  const MaterialTraits& traits = scene.world->traits();
  table.environment = traits.emission_constant ? EnvironmentMap(traits.average_emission)
                                               : map_environment(scene, resolution);
  table.has_environment = table.environment.mean_radiance() > 0.0f;
}

// Where the tree's boxes end: Embree, too, drops what lies far beyond.
constexpr float kLargestCoordinate = 1e17f;

// Whether what the light reaches depends on nothing but what is in the way: only then do paths that
// start at it carry what the camera's paths would find. Lights that shine through walls, on some
// kinds of surfaces only, or otherwise on each receiver are left to those.
bool shines_evenly(const LightTable& table, uint32_t light) {
  const auto unhidden = [](uint32_t visibility) {
    return (visibility & kVisibleScattered) == kVisibleScattered;
  };
  const auto alike = [](const Material& shader) { return !shader.traits().path_dependent; };
  if (table.is_triangle(light)) {
    const TriangleEmitter& emitter = table.emitter(light);
    return alike(*emitter.material) && unhidden(emitter.visibility);
  }
  if (table.is_environment(light)) {
    return alike(*table.scene->world) && unhidden(table.scene->world_visibility | kVisibleShadow);
  }
  const Lamp& lamp = table.lamp(light);
  // What varies over a lamp that faces its receiver varies with the receiver.
  const bool faces = lamp.soft && !lamp.delta && lamp.shader != nullptr;
  return lamp.cast_shadow && unhidden(lamp.visibility | kVisibleShadow) && !faces &&
         (lamp.shader == nullptr || alike(*lamp.shader));
}

// Fills in the tree, the distant lights' shares and the powers.
void weigh_lights(LightTable& table) {
  const uint32_t count = table.count();
  std::vector<double> intensity(count), irradiance(count), power(count);
  const double radius = static_cast<double>(table.radius);
  const double disk = kPiDouble * radius * radius;
  double largest = 0.0;
  for (uint32_t light = 0; light < count; ++light) {
    if (table.is_triangle(light)) {
      intensity[light] = triangle_intensity(table, light);
      power[light] = 2.0 * kPiDouble * intensity[light];
    } else if (table.is_environment(light)) {
      irradiance[light] = kPiDouble * static_cast<double>(table.environment.mean_radiance());
      power[light] = disk * irradiance[light] * 4.0;
    } else {
      const Lamp& lamp = table.lamp(light);
      const auto watts = static_cast<double>(lamp.power);
      intensity[light] = lamp_intensity(lamp);
      irradiance[light] = lamp.kind == LightKind::kSun ? watts : 0.0;
      power[light] = lamp.kind == LightKind::kSun ? disk * watts : watts;
    }
    largest = std::max(largest, std::max(intensity[light], irradiance[light]));
    table.total_power += power[light];
  }
  for (uint32_t light = 0; light < count; ++light) {
    if (!shines_evenly(table, light)) {
      table.uneven += power[light] > 0.0 ? 1 : 0;
      power[light] = 0.0;
    }
  }
  table.by_power.lights = AliasTable(power);

  std::vector<LightBounds> bounds;
  std::vector<uint32_t> lights;
  for (uint32_t light = 0; light < count; ++light) {
    if (irradiance[light] > 0.0) {
      table.distant.push_back(light);
      table.distant_irradiance.push_back(
          std::max(static_cast<float>(irradiance[light] / largest), kSmallestImportance));
    } else if (intensity[light] > 0.0) {
      LightBounds b = table.is_triangle(light) ? triangle_bounds(table.triangles[light])
                                               : lamp_bounds(table.lamp(light));
      b.intensity = std::max(static_cast<float>(intensity[light] / largest), kSmallestImportance);
      // Squares of the tree's distances must not overflow.
      b.lower = min(max(b.lower, splat(-kLargestCoordinate)), splat(kLargestCoordinate));
      b.upper = min(max(b.upper, splat(-kLargestCoordinate)), splat(kLargestCoordinate));
      bounds.push_back(b);
      lights.push_back(light);
    }
  }
  table.tree = LightTree(bounds, lights);
}

}  // namespace

Color environment_radiance(const Scene& scene, Vec3f d, uint32_t flags, const PathDepth& depth) {
  const MaterialTraits& traits = scene.world->traits();
  if (traits.emission_constant) {
    return bounded_radiance(traits.average_emission);
  }
  SurfacePoint point;
  point.scene = &scene;
  point.p = d;
  point.ng = point.ns = point.wo = -d;
  point.ray_flags = flags;
  point.depth = depth;
  return bounded_radiance(scene.world->emission(point));
}

std::unique_ptr<const LightTable> build_light_table(
    const Scene& scene, std::span<const LightDesc> lamps,
    std::vector<std::unique_ptr<Material>> lamp_shaders, std::vector<std::string>& warnings,
    int environment_resolution) {
  auto table = std::make_unique<LightTable>();
  table->scene = &scene;
  table->lamp_shaders = std::move(lamp_shaders);
  table->center = scene.center;
  table->radius = scene.radius;
  add_triangles(scene, *table);
  std::vector<LampBox> boxes;
  for (size_t i = 0; i < lamps.size(); ++i) {
    const Material* shader =
        i < table->lamp_shaders.size() ? table->lamp_shaders[i].get() : nullptr;
    const Lamp lamp = make_lamp(lamps[i], scene.origin(), shader, warnings);
    table->lamps.push_back(lamp);
    if (!lamp.delta && lamp.power != 0.0f) {
      // Cameras meet any lamp with a size; scattered rays those that Blender's multiple importance
      // is on for, and suns always need it (Cycles, light.h and shade_background.h).
      const uint32_t others = lamp.hittable ? lamp.visibility & ~uint32_t{kVisibleCamera} : 0u;
      if (lamp.kind == LightKind::kSun) {
        table->visible_suns |= lamp.hittable ? lamp.visibility : 0u;
      } else {
        table->visible_lamps |= others | (lamp.visibility & kVisibleCamera);
        const LightBounds b = lamp_bounds(lamp);
        boxes.push_back({b.lower, b.upper, static_cast<uint32_t>(i)});
      }
    }
  }
  table->lamp_bvh = LampBvh(boxes);
  choose_environment(scene, environment_resolution, *table);
  weigh_lights(*table);
  return table;
}

}  // namespace vernier
