// What a scene needs of the renderer: computed once when it is compiled, and shown to the user.
#pragma once

#include <cstdint>

namespace vernier {

struct Requirements {
  uint64_t triangles = 0;            // stored
  uint64_t instanced_triangles = 0;  // as instances multiply them
  uint64_t instances = 0;
  uint64_t lamps = 0;
  uint64_t emissive_triangles = 0;
  uint64_t constant_materials = 0;
  uint64_t program_materials = 0;
  bool programs = false;             // some material runs a program
  bool transparent_shadows = false;  // some surface may let shadow rays through
  bool environment = false;
  bool textured_emission = false;  // emission varies over a surface
  bool depth_of_field = false;
  bool singular_lobes = false;  // mirrors, clear glass
  bool caustics = false;        // a singular or glossy chain may join a light and a surface
  bool transmission = false;    // some lobe passes to the other side
  bool instancing = false;
  bool light_tree = false;
  bool hidden_from_rays = false;  // some object or lamp is invisible to some kind of ray
  // Some object is visible to some kinds of scattered rays only, so that what a path from a light
  // meets would depend on what comes after: no such paths then.
  bool uneven_visibility = false;
  // Lights at which no path may start (LightSampler::guide_by_power).
  uint64_t uneven_lights = 0;
  bool things_in_lamps = false;  // see lamps_hold_things (lights/lamp_contents.h)
  bool path_dependent = false;   // some material reads what the path has been through
  // Some material that lets light through reads which side it is seen from.
  bool transmits_by_side = false;
};

}  // namespace vernier
