// The inputs of the surface closures, as Blender's shader nodes name them.
//
// Values are taken as the sockets give them and are clamped where Cycles clamps them. Angles of
// anisotropy are turns (1 is a full circle), lengths of thin films are nanometres. A tangent need
// be neither unit nor orthogonal to the normal; the zero vector means isotropic.
#pragma once

#include <cstdint>

#include "math/vec.h"

namespace vernier {

enum class Distribution : uint8_t { kGgx, kMultiGgx, kBeckmann, kAshikhminShirley };

struct ThinFilm {
  float thickness = 0.0f;  // nanometres; at most 0.1: no film
  float ior = 1.33f;
};

// Diffuse BSDF. Roughness below 1e-5 is Lambert, else Oren-Nayar.
struct DiffuseParams {
  float roughness = 0.0f;
  Color color{1, 1, 1};  // albedo between facets; the lobe's weight holds the colour itself
};

// Glossy BSDF: reflection without a Fresnel term.
struct GlossyParams {
  Distribution distribution = Distribution::kMultiGgx;
  float roughness = 0.5f;
  float anisotropy = 0.0f;  // [-0.99, 0.99]
  float rotation = 0.0f;
  Vec3f tangent;
  Color color{1, 1, 1};  // for light scattered between facets; the weight holds the colour too
};

// Metallic BSDF: a conductor, by its complex index or by Adobe's F82 tint.
struct MetallicParams {
  Distribution distribution = Distribution::kMultiGgx;
  bool physical = false;
  Color base_color{0.617f, 0.577f, 0.540f}, edge_tint{0.695f, 0.726f, 0.770f};  // not physical
  Color ior{2.757f, 2.513f, 2.231f}, extinction{3.867f, 3.404f, 3.009f};        // physical
  float roughness = 0.5f;
  float anisotropy = 0.0f;  // [0, 1]
  float rotation = 0.0f;
  Vec3f tangent;
  ThinFilm film;
};

// Glass BSDF: reflection and refraction. The colour is here, not in the lobe's weight.
struct GlassParams {
  Distribution distribution = Distribution::kMultiGgx;
  Color color{1, 1, 1};
  float roughness = 0.0f;
  float ior = 1.5f;  // of the inside, relative to the outside
  ThinFilm film;
};

// Refraction BSDF: refraction alone, without a Fresnel term.
struct RefractionParams {
  Distribution distribution = Distribution::kGgx;
  float roughness = 0.0f;
  float ior = 1.45f;
};

// Toon BSDF.
struct ToonParams {
  bool glossy = false;
  float size = 0.5f, smooth = 0.0f;  // [0, 1]: parts of a right angle
};

// Principled BSDF of Blender 4.0 to 5.2. What Cycles renders as subsurface scattering is rendered
// as diffuse reflection of the same colour.
struct PrincipledParams {
  bool multi_scatter = true;  // the node's distribution: Multiscatter GGX
  bool thin_wall = false;
  Color base_color{0.8f, 0.8f, 0.8f};
  float metallic = 0.0f;
  float roughness = 0.5f;
  float ior = 1.5f;
  float alpha = 1.0f;
  float diffuse_roughness = 0.0f;
  float subsurface_weight = 0.0f;
  float subsurface_anisotropy = 0.0f;  // read in thin-walled mode only
  float specular_ior_level = 0.5f;
  Color specular_tint{1, 1, 1};
  float anisotropic = 0.0f;
  float anisotropic_rotation = 0.0f;
  Vec3f tangent;
  float transmission_weight = 0.0f;
  float coat_weight = 0.0f;
  float coat_roughness = 0.03f;
  float coat_ior = 1.5f;
  Color coat_tint{1, 1, 1};
  Vec3f coat_normal;  // the zero vector: the base's normal
  float sheen_weight = 0.0f;
  float sheen_roughness = 0.5f;
  Color sheen_tint{1, 1, 1};
  Color emission_color{1, 1, 1};
  float emission_strength = 0.0f;
  ThinFilm film;
};

}  // namespace vernier
