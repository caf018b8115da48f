// Fresnel reflectance of dielectrics, conductors and artistic metals, for unpolarised light.
#pragma once

#include "math/vec.h"

namespace vernier {

// Reflectance at perpendicular incidence of a relative index of refraction.
inline float f0_from_ior(float ior) { return square((ior - 1.0f) / (ior + 1.0f)); }

// The index above 1 whose perpendicular reflectance is f0, which is clamped to [0, 0.99].
inline float ior_from_f0(float f0) {
  const float r = std::sqrt(clamp(f0, 0.0f, 0.99f));
  return (1.0f + r) / (1.0f - r);
}

// Squared amplitudes of both polarisations, the signs of the amplitudes (cosines of the phase
// shift), and the cosine of the refracted ray with the normal on the incident side (not positive).
struct PolarizedFresnel {
  float s = 1.0f, p = 1.0f;
  float sign_s = 1.0f, sign_p = 1.0f;
  float cos_t = 0.0f;
};

// `eta` is the index beyond the surface over that on the incident side (Born and Wolf, section
// 1.5). The sign of cos_i does not matter.
inline PolarizedFresnel fresnel_polarized(float cos_i, float eta) {
  const float g2 = eta * eta - (1.0f - cos_i * cos_i);
  if (!(g2 > 0.0f)) {
    return {};  // total internal reflection
  }
  const float c = std::abs(cos_i);
  const float g = std::sqrt(g2);  // eta cos_t
  const float cos_t = g / eta;
  const float amplitude_s = (c - g) / (c + g);
  const float amplitude_p = (eta * c - cos_t) / (eta * c + cos_t);
  return {amplitude_s * amplitude_s, amplitude_p * amplitude_p, amplitude_s >= 0.0f ? 1.0f : -1.0f,
          amplitude_p >= 0.0f ? 1.0f : -1.0f, -cos_t};
}

// The mean of both polarisations, with a single division.
inline float fresnel_dielectric(float cos_i, float eta) {
  const float c = std::abs(cos_i), eta2 = eta * eta;
  const float g2 = eta2 - (1.0f - c * c);
  if (!(g2 > 0.0f)) {
    return 1.0f;  // total internal reflection
  }
  const float g = std::sqrt(g2), q = eta2 * c;
  // s = (c - g) / (c + g), p = (q - g) / (q + g)
  const float s = (c - g) * (q + g), p = (q - g) * (c + g);
  const float d = square((c + g) * (q + g));
  return d > 0.0f ? std::min(0.5f * (s * s + p * p) / d, 1.0f) : 1.0f;  // 0: all underflows
}

// Average of fresnel_dielectric over the cosine-weighted hemisphere: the fit of Kulla and Conty,
// "Revisiting Physically Based Shading at Imageworks" (2017).
inline float fresnel_dielectric_average(float eta) {
  return eta < 1.0f ? 0.997118f + eta * (0.1014f - eta * (0.965241f + eta * 0.130607f))
                    : (eta - 1.0f) / (4.08567f + 1.00071f * eta);
}

// What a metal with complex index n + ik reflects for one channel, incident from index `outside`
// (Born and Wolf, section 14.4.1). The phase factors exp(i phi) of both polarisations are only
// computed when asked for; phi_s = phi_p at grazing incidence.
struct ConductorFresnel {
  float s = 0.0f, p = 0.0f;
  float phase_s_re = 1.0f, phase_s_im = 0.0f, phase_p_re = 1.0f, phase_p_im = 0.0f;
};

template <bool kPhase = false>
inline ConductorFresnel fresnel_conductor_polarized(float cos_i, float outside, float n, float k) {
  const auto ratio = [](float a, float b) { return b > 0.0f ? a / b : 0.0f; };
  const float difference = n * n - k * k, product = 2.0f * n * k, out2 = outside * outside;
  const float t1 = difference - out2 * (1.0f - cos_i * cos_i);
  const float t2 = std::sqrt(t1 * t1 + product * product);
  const float u2 = std::max(0.5f * (t2 + t1), 0.0f), v2 = std::max(0.5f * (t2 - t1), 0.0f);
  const float u = std::sqrt(u2), v = std::sqrt(v2);
  const float oc = outside * cos_i;
  ConductorFresnel r;
  r.s = ratio(square(oc - u) + v2, square(oc + u) + v2);
  const float t3 = difference * cos_i, t4 = product * cos_i;
  r.p = ratio(square(t3 - outside * u) + square(t4 - outside * v),
              square(t3 + outside * u) + square(t4 + outside * v));
  if constexpr (kPhase) {
    const float s_re = square(oc) - u2 - v2, s_im = -2.0f * oc * v;
    if (const float m = std::sqrt(s_re * s_re + s_im * s_im); m > 0.0f) {
      r.phase_s_re = s_re / m, r.phase_s_im = s_im / m;
    }
    const float p_re = square((n * n + k * k) * cos_i) - out2 * (u2 + v2);
    const float p_im = 2.0f * oc * (product * u - difference * v);
    if (const float m = std::sqrt(p_re * p_re + p_im * p_im); m > 0.0f) {
      r.phase_p_re = p_re / m, r.phase_p_im = p_im / m;
    }
  }
  return r;
}

inline Color fresnel_conductor(float cos_i, Color n, Color k) {
  Color r;
  for (int i = 0; i < 3; ++i) {
    const ConductorFresnel f = fresnel_conductor_polarized(cos_i, 1.0f, n[i], k[i]);
    r[i] = 0.5f * (f.s + f.p);
  }
  return r;
}

// The F82 model: Schlick's curve less b cos (1 - cos)^6, which lowers it about 82 degrees
// (Kutz, Hasan and Edmondson 2021, "Novel aspects of the Adobe Standard Material").
inline constexpr float kF82Power5 = 0.46266436f;   // (6/7)^5, at cos = 1/7
inline constexpr float kF82Scale = 17.651384602f;  // 7 / (6/7)^6

inline float f82_b(float f0, float f82) { return kF82Scale * (lerp(f0, 1.0f, kF82Power5) - f82); }
// b where `tint` is the reflectance at 82 degrees over Schlick's.
inline Color f82_b_from_tint(Color f0, Color tint) {
  return lerp(f0, splat(1.0f), kF82Power5) * kF82Scale * (splat(1.0f) - tint);
}
inline float fresnel_f82(float cos_i, float f0, float b) {
  const float m = saturate(1.0f - cos_i);
  const float m5 = square(square(m)) * m;
  return saturate(lerp(f0, 1.0f, m5) - b * cos_i * m5 * m);
}
inline Color fresnel_f82(float cos_i, Color f0, Color b) {
  const float m = saturate(1.0f - cos_i);
  const float m5 = square(square(m)) * m;
  const Color f = lerp(f0, splat(1.0f), m5) - b * (cos_i * m5 * m);
  return {saturate(f.x), saturate(f.y), saturate(f.z)};
}
// Its average over the cosine-weighted hemisphere, in closed form.
inline Color f82_average(Color f0, Color b) {
  return lerp(f0, splat(1.0f), 1.0f / 21.0f) - b * (1.0f / 126.0f);
}
// The average of a physical conductor, by fitting F82 to it at 0 and 82 degrees, as Cycles does.
inline Color conductor_average(Color n, Color k) {
  const Color f0 = fresnel_conductor(1.0f, n, k);
  const Color f82 = fresnel_conductor(1.0f / 7.0f, n, k);
  const Color b{f82_b(f0.x, f82.x), f82_b(f0.y, f82.y), f82_b(f0.z, f82.z)};
  const Color f = f82_average(f0, b);
  return {saturate(f.x), saturate(f.y), saturate(f.z)};
}

}  // namespace vernier
