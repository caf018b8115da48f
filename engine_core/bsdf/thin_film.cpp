#include "bsdf/thin_film.h"

#include <array>

#include "bsdf/fresnel.h"
#include "bsdf/microfacet_lobe.h"

namespace vernier {
namespace {

// CIE 1931 colour matching functions x, y, z every 10 nm from 360 nm (CIE 018:2019, table 6).
constexpr int kRows = 43;
constexpr double kFirst = 360.0, kStep = 10.0;
constexpr std::array<std::array<double, 3>, kRows> kMatching{{
    {0.0001299, 0.000003917, 0.0006061},
    {0.0004149, 0.00001239, 0.001946},
    {0.001368, 0.000039, 0.006450},
    {0.004243, 0.00012, 0.02005},
    {0.01431, 0.000396, 0.06785},
    {0.04351, 0.00121, 0.2074},
    {0.13438, 0.004, 0.6456},
    {0.2839, 0.0116, 1.3856},
    {0.34828, 0.023, 1.74706},
    {0.3362, 0.038, 1.77211},
    {0.2908, 0.06, 1.6692},
    {0.19536, 0.09098, 1.28764},
    {0.09564, 0.13902, 0.81295},
    {0.03201, 0.20802, 0.46518},
    {0.0049, 0.323, 0.272},
    {0.0093, 0.503, 0.1582},
    {0.06327, 0.71, 0.07825},
    {0.1655, 0.862, 0.04216},
    {0.2904, 0.954, 0.0203},
    {0.43345, 0.99495, 0.00875},
    {0.5945, 0.995, 0.0039},
    {0.7621, 0.952, 0.0021},
    {0.9163, 0.87, 0.00165},
    {1.0263, 0.757, 0.0011},
    {1.0622, 0.631, 0.0008},
    {1.0026, 0.503, 0.00034},
    {0.85445, 0.381, 0.00019},
    {0.6424, 0.265, 0.00005},
    {0.4479, 0.175, 0.00002},
    {0.2835, 0.107, 0.0},
    {0.1649, 0.061, 0.0},
    {0.0874, 0.032, 0.0},
    {0.04677, 0.017, 0.0},
    {0.0227, 0.00821, 0.0},
    {0.011359, 0.004102, 0.0},
    {0.00579, 0.002091, 0.0},
    {0.002899, 0.001047, 0.0},
    {0.00144, 0.00052, 0.0},
    {0.00069, 0.000249, 0.0},
    {0.000332, 0.00012, 0.0},
    {0.000166, 0.00006, 0.0},
    {0.000083, 0.00003, 0.0},
    {0.000042, 0.000015, 0.0},
}};
// XYZ to linear Rec.709 (ITU-R BT.709-6 primaries, D65).
constexpr double kRec709[3][3] = {{3.2404542, -1.5371385, -0.4985314},
                                  {-0.9692660, 1.8760108, 0.0415560},
                                  {0.0556434, -0.2040259, 1.0572252}};

// Sensitivity of a channel to cos and sin of 2 pi OPD / wavelength: the Fourier transforms of the
// channels' matching functions, over those at 0. OPD: optical path difference, nanometres.
class FilmTable {
 public:
  FilmTable() {
    std::array<std::array<double, 6>, kSize> sums{};  // real parts, imaginary parts
    constexpr int kParts = 5;  // samples per row: cubic interpolation between rows
    for (int row = -1; row < kRows; ++row) {
      for (int part = 0; part < kParts; ++part) {
        const double t = static_cast<double>(part) / kParts;
        const double wavelength = kFirst + kStep * (row + t);
        double xyz[3], rgb[3];
        for (size_t c = 0; c < 3; ++c) {
          xyz[c] = catmull_rom(at(row - 1, c), at(row, c), at(row + 1, c), at(row + 2, c), t);
        }
        for (int c = 0; c < 3; ++c) {
          rgb[c] = kRec709[c][0] * xyz[0] + kRec709[c][1] * xyz[1] + kRec709[c][2] * xyz[2];
        }
        const double turn = 2.0 * 3.14159265358979323846 * kSpacing / wavelength;
        const double step_re = std::cos(turn), step_im = -std::sin(turn);
        double re = 1.0, im = 0.0;
        for (auto& sum : sums) {
          for (size_t c = 0; c < 3; ++c) {
            sum[c] += re * rgb[c];
            sum[3 + c] += im * rgb[c];
          }
          const double next = re * step_re - im * step_im;
          im = re * step_im + im * step_re;
          re = next;
        }
      }
    }
    for (size_t i = 0; i < kSize; ++i) {
      for (size_t c = 0; c < 3; ++c) {
        table_[c][i] = {static_cast<float>(sums[i][c] / sums[0][c]),
                        static_cast<float>(sums[i][3 + c] / sums[0][c])};
      }
    }
  }

  Vec2f operator()(int channel, float opd) const {
    const float x = std::min(opd * static_cast<float>(1.0 / kSpacing), kSize - 1.0f);
    const auto i = std::min(static_cast<size_t>(x), kSize - 2);
    const float t = x - static_cast<float>(i);
    const auto& row = table_[static_cast<size_t>(channel)];
    return row[i] * (1.0f - t) + row[i + 1] * t;
  }

 private:
  static constexpr size_t kSize = 512;
  static constexpr double kSpacing = 18.7;  // nanometres: a twentieth of the shortest wavelength

  static double at(int row, size_t c) {
    return row >= 0 && row < kRows ? kMatching[static_cast<size_t>(row)][c] : 0.0;
  }
  static double catmull_rom(double a, double b, double c, double d, double t) {
    return b +
           0.5 * t * (c - a + t * (2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a)));
  }

  std::array<std::array<Vec2f, kSize>, 3> table_;
};

const FilmTable film_table;

// Belcour and Barla 2017, equation 10, to the third order: one polarisation. r12 and r23 are the
// reflectances above and below the film, (re, im) = exp(i (phi_23 + phi_21)).
float airy_sum(int channel, float r12, float r23, float opd, float re, float im) {
  const float t121 = 1.0f - r12;
  const float both = r12 * r23;
  if (!(both < 1.0f)) {
    return 1.0f;
  }
  const float s = t121 * t121 * r23 / (1.0f - both);
  const float amplitude = std::sqrt(both);
  float sum = r12 + s, c = s - t121;
  float phase_re = re, phase_im = im;
  for (int order = 1; order < 4; ++order) {
    c *= amplitude;
    const Vec2f v = film_table(channel, static_cast<float>(order) * opd);
    sum += 2.0f * c * (phase_re * v.x + phase_im * v.y);
    const float next = phase_re * re - phase_im * im;
    phase_im = phase_re * im + phase_im * re;
    phase_re = next;
  }
  return sum;
}

float smoothstep(float x) { return x * x * (3.0f - 2.0f * x); }

}  // namespace

float film_reflectance(int channel, ThinFilm film, const FilmSubstrate& substrate, float cos_i) {
  // Films thinner than 1 nm fade out: the sum does not describe them.
  const float ior =
      film.thickness < 1.0f ? lerp(1.0f, film.ior, smoothstep(film.thickness)) : film.ior;
  const PolarizedFresnel top = fresnel_polarized(cos_i, ior);
  if (top.s >= 1.0f && top.p >= 1.0f) {
    return 1.0f;
  }
  const float cos_film = -top.cos_t;
  float bottom_s, bottom_p, s_re, s_im = 0.0f, p_re, p_im = 0.0f;
  if (substrate.metal) {
    const ConductorFresnel r =
        fresnel_conductor_polarized<true>(cos_film, ior, substrate.n, substrate.k);
    bottom_s = r.s, bottom_p = r.p;
    if (substrate.f82 >= 0.0f) {
      // F82 with the reflectance at normal incidence under the film instead of under air.
      const float n = substrate.n / ior, k2 = square(substrate.k / ior);
      const float f0 = (square(n - 1.0f) + k2) / (square(n + 1.0f) + k2);
      bottom_s = bottom_p = fresnel_f82(cos_film, f0, f82_b(f0, substrate.f82));
    }
    s_re = r.phase_s_re, s_im = r.phase_s_im;
    p_re = r.phase_p_re, p_im = r.phase_p_im;
  } else {
    const PolarizedFresnel r = fresnel_polarized(cos_film, substrate.n / ior);
    if (r.s >= 1.0f && r.p >= 1.0f) {
      return 1.0f;
    }
    bottom_s = r.s, bottom_p = r.p;
    s_re = r.sign_s, p_re = r.sign_p;
  }
  const float opd = 2.0f * ior * film.thickness * cos_film;
  const float sum =
      airy_sum(channel, top.s, bottom_s, opd, -top.sign_s * s_re, -top.sign_s * s_im) +
      airy_sum(channel, top.p, bottom_p, opd, -top.sign_p * p_re, -top.sign_p * p_im);
  return saturate(0.5f * sum);
}

FresnelSplit film_fresnel(const Lobe& lobe, float cos_h, float eta, float film_ior) {
  const ThinFilm film{lobe.film.thickness, film_ior};
  Color r;
  switch (lobe.fresnel) {
    case FresnelKind::kConductor:
      for (int i = 0; i < 3; ++i) {
        r[i] = film_reflectance(i, film, {lobe.f0[i], lobe.b[i], true}, cos_h);
      }
      return {r, {}};
    case FresnelKind::kF82:
      for (int i = 0; i < 3; ++i) {
        // n and k from the reflectance and the edge tint (Gulbrandsen 2014, "Artist Friendly
        // Metallic Fresnel").
        const float f0 = std::min(lobe.f0[i], 0.999f);
        const float g = fresnel_f82(1.0f / 7.0f, lobe.f0[i], lobe.b[i]);
        const float root = std::sqrt(f0);
        const float n = lerp((1.0f + root) / (1.0f - root), (1.0f - f0) / (1.0f + f0), g);
        const float k = safe_sqrt((f0 * square(n + 1.0f) - square(n - 1.0f)) / (1.0f - f0));
        r[i] = film_reflectance(i, film, {n, k, true, g}, cos_h);
      }
      return {r, {}};
    default:
      break;
  }
  for (int i = 0; i < 3; ++i) {
    r[i] = film_reflectance(i, film, {eta, 0.0f, false}, cos_h);
  }
  // The film's reflectance can be below the bare surface's. A chosen f0 scales it by how near it
  // is to that, as in Cycles.
  const float f0 = f0_from_ior(eta);
  if (f0 > 1e-5f && f0 < 1.0f && !(r == splat(1.0f))) {
    for (int i = 0; i < 3; ++i) {
      const float s = saturate((r[i] - 1.0f) / (f0 - 1.0f));
      r[i] = std::min(r[i] * lerp(1.0f, lobe.f0[i] / f0, s), 1.0f);
    }
  }
  return {r * lobe.reflection_tint, (splat(1.0f) - r) * lobe.transmission_tint};
}

}  // namespace vernier
