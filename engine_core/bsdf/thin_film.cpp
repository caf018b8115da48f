#include "bsdf/thin_film.h"

#include "bsdf/fresnel.h"
#include "bsdf/microfacet_lobe.h"

namespace vernier {
float film_reflectance(int, ThinFilm, const FilmSubstrate& s, float cos_i) {
  return fresnel_dielectric(cos_i, s.n);
}
FresnelSplit film_fresnel(const Lobe& lobe, float cos_h, float eta, float film_ior) {
  (void)film_ior;
  Lobe l = lobe;
  l.film.thickness = 0;
  return lobe_fresnel(l, cos_h, eta, 1.f);
}
}  // namespace vernier
