#include "bsdf/energy_tables.h"

#include "bsdf/fresnel.h"
#include "bsdf/microfacet.h"

namespace vernier {
namespace {

constexpr int kFine = EnergyTables::kFine, kCoarse = EnergyTables::kCoarse;
// Quadrature nodes over visible normals: half of the azimuths (the lobe is symmetric) by height.
constexpr int kAzimuths = 16, kHeights = 24;
constexpr int kNodes = kAzimuths * kHeights;

// Grid coordinates are kept off the ends where the integrands degenerate.
float grid(int i, int size, float top = 1.0f) {
  return clamp(static_cast<float>(i) / static_cast<float>(size - 1), 1e-4f, top);
}

struct Facet {
  float cos_h;  // of the given direction with the facet's normal
  float z;      // of the facet's normal
};

// Visible normals of GGX seen along cosine mu, each of weight 1 / kNodes.
std::array<Facet, kNodes> visible_facets(float alpha, float mu) {
  std::array<Facet, kNodes> facets;
  const Vec3f v{safe_sqrt(1.0f - mu * mu), 0.0f, mu};
  for (int i = 0; i < kNodes; ++i) {
    const Vec2f u{(static_cast<float>(i % kAzimuths) + 0.5f) / (2.0f * kAzimuths),
                  (static_cast<float>(i / kAzimuths) + 0.5f) / kHeights};
    const Vec3f h = sample_ggx_visible(v, alpha, alpha, u);
    facets[static_cast<size_t>(i)] = {dot(v, h), h.z};
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
        sum += z > 0.0f ? masking(lambda, alpha * alpha, z) : 0.0f;
      }
      t.reflection[static_cast<size_t>(y * kFine + x)] = saturate(sum / kNodes);
    }
  }
  for (int x = 0; x < kFine; ++x) {
    t.reflection_average[static_cast<size_t>(x)] =
        hemisphere_average(t.reflection.data() + x, kFine, kFine);
  }
}

// One dielectric at one roughness and angle: its albedo, and the mean of fresnel_blend over the
// facets that reflect upward.
struct DielectricSums {
  float albedo = 0.0f, blend = 0.0f;
};

DielectricSums integrate_dielectric(const std::array<Facet, kNodes>& facets, float alpha2, float mu,
                                    float eta) {
  const float lambda = ggx_lambda(alpha2, mu);
  const float f0 = f0_from_ior(eta);
  const float inv_eta = 1.0f / eta;
  DielectricSums sums;
  for (const Facet f : facets) {
    const PolarizedFresnel r = fresnel_polarized(f.cos_h, eta);
    const float reflectance = 0.5f * (r.s + r.p);
    const float up = 2.0f * f.cos_h * f.z - mu;
    const float down = (inv_eta * f.cos_h + r.cos_t) * f.z - inv_eta * mu;
    const float reflected = up > 0.0f ? masking(lambda, alpha2, up) : 0.0f;
    const float refracted = down < 0.0f ? masking(lambda, alpha2, down) : 0.0f;
    sums.albedo += reflectance * reflected + (1.0f - reflectance) * refracted;
    sums.blend += up > 0.0f ? saturate((reflectance - f0) / (1.0f - f0)) : 0.0f;
  }
  return {saturate(sums.albedo / kNodes), saturate(sums.blend / kNodes)};
}

void fill_dielectric(EnergyTables& t) {
  for (int y = 0; y < kCoarse; ++y) {
    for (int x = 0; x < kCoarse; ++x) {
      const float alpha = square(grid(x, kCoarse)), mu = grid(y, kCoarse);
      const auto facets = visible_facets(alpha, mu);
      float schlick = 0.0f;
      for (const Facet f : facets) {
        const float m = saturate(1.0f - f.cos_h);
        schlick += 2.0f * f.cos_h * f.z - mu > 0.0f ? square(square(m)) * m : 0.0f;
      }
      const auto cell = static_cast<size_t>(y * kCoarse + x);
      t.schlick_blend[cell] = schlick / kNodes;
      for (int z = 0; z < kCoarse; ++z) {
        const auto entry = cell + static_cast<size_t>(z * EnergyTables::kPlane);
        const float eta = ior_from_f0(square(square(grid(z, kCoarse, 0.99f))));
        const DielectricSums outside = integrate_dielectric(facets, alpha * alpha, mu, eta);
        t.glass[0][entry] = outside.albedo;
        t.dielectric_blend[entry] = outside.blend;
        t.glass[1][entry] = integrate_dielectric(facets, alpha * alpha, mu, 1.0f / eta).albedo;
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
