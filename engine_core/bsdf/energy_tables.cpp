#include "bsdf/energy_tables.h"

#include "bsdf/fresnel.h"
#include "bsdf/microfacet.h"

namespace vernier {
namespace {

constexpr int kFine = EnergyTables::kFine, kCoarse = EnergyTables::kCoarse;
// Quadrature nodes over visible normals: half of the azimuths (the lobe is symmetric) by height.
constexpr int kAzimuths = 12, kHeights = 40;
constexpr int kNodes = kAzimuths * kHeights;

// Grid coordinates are kept off the ends where the integrands degenerate.
float grid(int i, int size, float top = 1.0f) {
  return clamp(static_cast<float>(i) / static_cast<float>(size - 1), 1e-4f, top);
}

struct Facet {
  float cos_h;   // of the given direction with the facet's normal
  float z;       // of the facet's normal
  float weight;  // all sum to 1
};

// Visible normals of GGX seen along cosine mu: sample_ggx_visible at the midpoints of a grid that
// is finer where u.y nears 1, at the long tail: u = 1 - (1-t)^3.
std::array<Facet, kNodes> visible_facets(float alpha, float mu) {
  static const std::array<float, kAzimuths> cosines = [] {
    std::array<float, kAzimuths> c;
    for (int i = 0; i < kAzimuths; ++i) {
      c[static_cast<size_t>(i)] = std::cos(kPi * (static_cast<float>(i) + 0.5f) / kAzimuths);
    }
    return c;
  }();
  const Vec3f v{safe_sqrt(1.0f - mu * mu), 0.0f, mu};
  const Vec3f s = normalize(Vec3f{alpha * v.x, 0.0f, v.z});
  // The midpoint rule gives the integral of 3 (1-t)^2 over [0, 1] as 1 - 1 / (4 kHeights^2).
  constexpr float normalization = kNodes * (1.0f - 0.25f / (kHeights * kHeights));
  std::array<Facet, kNodes> facets;
  for (int i = 0; i < kNodes; ++i) {
    const float rest = 1.0f - (static_cast<float>(i / kAzimuths) + 0.5f) / kHeights;
    const float z = rest * rest * rest * (1.0f + s.z) - s.z;
    const float r = std::sqrt(std::max(1.0f - z * z, 0.0f));
    const float cos_phi = cosines[static_cast<size_t>(i % kAzimuths)];
    const float x = alpha * (r * cos_phi + s.x), y2 = square(alpha * r) * (1.0f - square(cos_phi));
    const float hz = std::max(z + s.z, 0.0f);
    const float inverse = 1.0f / std::sqrt(x * x + y2 + hz * hz);
    facets[static_cast<size_t>(i)] = {(v.x * x + v.z * hz) * inverse, hz * inverse,
                                      3.0f * rest * rest / normalization};
  }
  return facets;
}

// G2 / G1 = (1 + L(given)) / (1 + L(given) + L(other)).
float masking(float lambda_given, float alpha2, float cos_other) {
  return (1.0f + lambda_given) / (1.0f + lambda_given + ggx_lambda(alpha2, cos_other));
}

// Integral of 2 mu E(mu) over [0, 1], exact for E linear between its entries.
float hemisphere_average(const float* e, int stride, int size) {
  const float step = 1.0f / static_cast<float>(size - 1);
  float sum = 0.0f;
  for (int i = 0; i + 1 < size; ++i) {
    const float a = static_cast<float>(i) * step, b = a + step;
    const float ea = e[i * stride], eb = e[(i + 1) * stride];
    sum += step * (ea * (2.0f * a + b) + eb * (a + 2.0f * b)) * (1.0f / 3.0f);
  }
  return sum;
}

void fill_reflection(EnergyTables& t) {
  for (int y = 0; y < kFine; ++y) {
    for (int x = 0; x < kFine; ++x) {
      const float alpha = square(grid(x, kFine)), mu = grid(y, kFine);
      const float lambda = ggx_lambda(alpha * alpha, mu);
      float sum = 0.0f;
      for (const Facet f : visible_facets(alpha, mu)) {
        const float z = 2.0f * f.cos_h * f.z - mu;
        sum += z > 0.0f ? f.weight * masking(lambda, alpha * alpha, z) : 0.0f;
      }
      t.reflection[static_cast<size_t>(y * kFine + x)] = saturate(sum);
    }
  }
  for (int x = 0; x < kFine; ++x) {
    t.reflection_average[static_cast<size_t>(x)] =
        hemisphere_average(t.reflection.data() + x, kFine, kFine);
  }
}

// All dielectrics of the third axis, and then their inverses, side by side for vector instructions.
constexpr int kLanes = 2 * kCoarse;
struct Dielectrics {
  std::array<float, kLanes> eta, inverse, f0;

  Dielectrics() {
    for (int i = 0; i < kLanes; ++i) {
      const float above = ior_from_f0(square(square(grid(i % kCoarse, kCoarse, 0.99f))));
      const auto k = static_cast<size_t>(i);
      eta[k] = i < kCoarse ? above : 1.0f / above;
      inverse[k] = 1.0f / eta[k];
      f0[k] = f0_from_ior(eta[k]);
    }
  }
};

// Their albedos at one roughness and angle, and the means of (F - F0) / (1 - F0) over the facets
// that reflect upward.
struct DielectricSums {
  std::array<float, kLanes> albedo{}, blend{};
};

DielectricSums integrate_dielectrics(const Dielectrics& d, const std::array<Facet, kNodes>& facets,
                                     float alpha2, float mu) {
  const float lambda = 1.0f + ggx_lambda(alpha2, mu);
  DielectricSums sums;
  for (const Facet f : facets) {
    const float c = f.cos_h, sin2 = 1.0f - c * c;
    const float up = 2.0f * c * f.z - mu;
    const float upward = up > 0.0f ? f.weight : 0.0f;
    const float reflected = up > 0.0f ? masking(lambda - 1.0f, alpha2, up) : 0.0f;
    for (size_t k = 0; k < kLanes; ++k) {
      // fresnel_polarized, without branches.
      const float eta = d.eta[k], inverse = d.inverse[k];
      const float g2 = eta * eta - sin2;
      const float g = std::sqrt(std::max(g2, 0.0f)), cos_t = g * inverse;
      const float s = (c - g) / (c + g), p = (eta * c - cos_t) / (eta * c + cos_t);
      const float reflectance = g2 > 0.0f ? 0.5f * (s * s + p * p) : 1.0f;
      const float down = (inverse * c - cos_t) * f.z - inverse * mu;
      const float tan2 = std::max(1.0f / (down * down) - 1.0f, 0.0f);
      const float lambda_down = 0.5f * (std::sqrt(1.0f + alpha2 * tan2) - 1.0f);
      // From the denser side grazing light can be refracted upward, and meets facets again. That is
      // not counted as missing (nor does Cycles): a few lucky samples would have to make up for it.
      const float refracted = lambda / (lambda + lambda_down);
      sums.albedo[k] += f.weight * (reflectance * reflected + (1.0f - reflectance) * refracted);
      const float blend = (reflectance - d.f0[k]) / (1.0f - d.f0[k]);
      sums.blend[k] += upward * std::min(std::max(blend, 0.0f), 1.0f);
    }
  }
  return sums;
}

void fill_dielectric(EnergyTables& t) {
  const Dielectrics dielectrics;
  for (int y = 0; y < kCoarse; ++y) {
    for (int x = 0; x < kCoarse; ++x) {
      const float alpha = square(grid(x, kCoarse)), mu = grid(y, kCoarse);
      const auto facets = visible_facets(alpha, mu);
      float schlick = 0.0f;
      for (const Facet f : facets) {
        const float m = saturate(1.0f - f.cos_h);
        schlick += 2.0f * f.cos_h * f.z - mu > 0.0f ? f.weight * square(square(m)) * m : 0.0f;
      }
      const auto cell = static_cast<size_t>(y * kCoarse + x);
      t.schlick_blend[cell] = schlick;
      // At the third axis' origin nothing is bent or lost (see kMatchedIor).
      const DielectricSums sums = integrate_dielectrics(dielectrics, facets, alpha * alpha, mu);
      for (size_t z = 0; z < kCoarse; ++z) {
        const size_t entry = cell + z * EnergyTables::kPlane;
        t.glass[0][entry] = z == 0 ? 1.0f : saturate(sums.albedo[z]);
        t.glass[1][entry] = z == 0 ? 1.0f : saturate(sums.albedo[kCoarse + z]);
        t.dielectric_blend[entry] = sums.blend[z];
      }
    }
  }
  for (size_t side = 0; side < 2; ++side) {
    for (int z = 0; z < kCoarse; ++z) {
      for (int x = 0; x < kCoarse; ++x) {
        t.glass_average[side][static_cast<size_t>(z * kCoarse + x)] = hemisphere_average(
            t.glass[side].data() + z * EnergyTables::kPlane + x, kCoarse, kCoarse);
      }
    }
  }
}

}  // namespace

EnergyTables::EnergyTables() {
  fill_reflection(*this);
  fill_dielectric(*this);
}

const EnergyTables energy_tables;

}  // namespace vernier
