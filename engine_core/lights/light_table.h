// What a LightSampler knows: its lights by number, and how one is chosen.
#pragma once

#include <memory>
#include <vector>

#include "lights/emission_guide.h"
#include "lights/environment.h"
#include "lights/lamp.h"
#include "lights/lamp_bvh.h"
#include "lights/light_tree.h"
#include "lights/triangle_index.h"
#include "lights/triangle_light.h"
#include "math/distribution.h"

namespace vernier {

class Material;
class Scene;

struct LightTable {
  const Scene* scene = nullptr;
  std::vector<std::unique_ptr<Material>> lamp_shaders;

  // Lights by number: triangles, lamps, environment.
  std::vector<TriangleLight> triangles;
  std::vector<TriangleEmitter> emitters;
  std::vector<Lamp> lamps;
  bool has_environment = false;  // the world emits something that can be sampled
  EnvironmentMap environment;
  TriangleIndex triangle_index;

  LampBvh lamp_bvh;                       // over lamps of finite size and place
  LightTree tree;                         // over triangles and lamps at finite places
  std::vector<uint32_t> distant;          // suns and the environment: lights
  std::vector<float> distant_irradiance;  // of each, on the scale of the tree's
  uint32_t visible_lamps = 0;  // union of the Visibility bits of lamps that rays can meet
  uint32_t visible_suns = 0;

  uint32_t uneven = 0;     // lights that shine, and at which no path may start
  EmissionGuide by_power;  // in proportion to the lights' power
  double total_power = 0;
  Vec3f center;  // the bounding sphere of what infinite lights shine on
  float radius = 0;

  uint32_t first_lamp() const { return static_cast<uint32_t>(triangles.size()); }
  uint32_t environment_light() const { return first_lamp() + static_cast<uint32_t>(lamps.size()); }
  uint32_t count() const { return environment_light() + (has_environment ? 1u : 0u); }
  bool is_triangle(uint32_t light) const { return light < first_lamp(); }
  bool is_environment(uint32_t light) const { return light >= environment_light(); }
  const TriangleEmitter& emitter(uint32_t light) const {
    return emitters[triangles[light].emitter];
  }
  const Lamp& lamp(uint32_t light) const { return lamps[light - first_lamp()]; }
};

}  // namespace vernier
