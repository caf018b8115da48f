// What Bsdf stores: the lobes, and what each is seen from a given direction.
#pragma once

#include <cstdint>

#include "bsdf/params.h"
#include "math/vec.h"

namespace vernier {

enum class LobeKind : uint8_t {
  kLambert,
  kOrenNayar,
  kSheen,
  kVelvet,
  kDiffuseToon,
  kGlossyToon,
  kAshikhminShirley,
  kReflection,  // microfacets that reflect
  kGlass,       // microfacets that reflect and refract
  kRefraction,  // microfacets that refract
};

enum class FresnelKind : uint8_t {
  kNone,        // white (where a refraction exists)
  kDielectric,  // the true curve
  kSchlick,     // the true curve blended from f0 to white
  kF82,         // f0, b
  kConductor,   // f0 and b hold n and k
};

// What every lobe must say.
struct LobeTraits {
  LobeKind kind = LobeKind::kLambert;
  FresnelKind fresnel = FresnelKind::kNone;
  bool beckmann = false;
  bool mirrored = false;  // acts on what lies beyond the surface, seen in the mirror of the normal
  bool compensate = false;  // scale up by the energy tables
  bool singular = false;
  bool bumped = false;     // the normal is not ns: Conty's bump shadowing applies
  bool corrected = false;  // the normal may reflect below ng: raise it, as Cycles does
  bool is_layer = false;   // what refers to this lobe lies below it
  bool thin = false;       // one side of a thin dielectric sheet: weighted by its reflectance
  uint8_t reflection_bits = 0, transmission_bits = 0;  // LobeBits of its events; 0: it makes none
  int8_t above = -1;                                   // lobe whose layer lies over this one
};

// A lobe without anything that depends on direction. Normals are on the side of ng that wo was on
// at begin(); `eta` is the index beyond the surface over that on this side. Only microfacet lobes
// set all fields; the others set what they read.
struct Lobe : LobeTraits {
  Color weight;
  Vec3f normal;
  Vec3f tangent;  // where alpha_x != alpha_y
  float alpha_x = 1.0f, alpha_y = 1.0f;
  float eta = 1.0f;
  Color f0, b;
  Color reflection_tint, transmission_tint;
  ThinFilm film;
  // kSchlick: the true curve's value at normal incidence, and 1 / (1 - that).
  float true_f0 = 0.0f, blend_scale = 0.0f;
  float roughness = 0.0f;       // coordinate in the energy tables
  float ior_axis = 0.0f;        // likewise, of eta or its inverse
  Color average_fresnel;        // Fss of Kulla and Conty: compensate
  float average_energy = 1.0f;  // E_avg, for reflection lobes
  float layer_share = 1.0f;     // part of what is below that is_layer covers
  float bump_alpha2 = 0.0f;
};

// A lobe as seen from one direction.
struct LobeSide {
  Vec3f normal;  // on that direction's side
  Color scale;   // factor of F where the direction is the camera's
  float select;  // probability of sampling this lobe, given the direction; before finish(): weight
  float energy;  // part of scale that makes up for multiple scattering
  float a, b;    // sheen: the linear transform; Oren-Nayar: a is its albedo
};

// An array that is not initialised, of values that need not be.
template <typename T, int kSize>
struct RawArray {
  union {
    T items[kSize];
  };
  RawArray() {}
  T& operator[](int i) { return items[i]; }
  const T& operator[](int i) const { return items[i]; }
};

}  // namespace vernier
