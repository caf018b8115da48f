// Iridescence of a thin film over a dielectric or a metal.
#pragma once

#include "bsdf/params.h"
#include "math/vec.h"

namespace vernier {

// At most this thick (nanometres) there is no film, as in Cycles.
inline constexpr float kNoFilm = 0.1f;

// What lies under the film, for one colour channel.
struct FilmSubstrate {
  float n = 1.5f;  // index of refraction over that of the outside
  float k = 0.0f;  // extinction (metals)
  bool metal = false;
  float f82 = -1.0f;  // metals: not negative gives F82's value at 82 degrees instead of n, k
};

// Reflectance in channel 0 to 2 (red, green, blue of Rec.709) of a film in air seen at cos_i: the
// Airy sum over interference orders, integrated over the spectrum in Fourier space (Belcour and
// Barla 2017, "A Practical Extension to Microfacet Theory for the Modeling of Varying
// Iridescence").
float film_reflectance(int channel, ThinFilm film, const FilmSubstrate& substrate, float cos_i);

}  // namespace vernier
