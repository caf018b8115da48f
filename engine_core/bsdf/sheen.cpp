#include "bsdf/sheen.h"

#include <array>

#include "bsdf/energy_tables.h"
#include "bsdf/sheen_coefficients.h"

namespace vernier {
namespace {

constexpr int kSize = 32;

// Values of the first Chebyshev polynomials at 2 sqrt(v) - 1.
template <int kTerms>
std::array<float, kTerms> chebyshev(float v) {
  const float x = 2.0f * std::sqrt(v) - 1.0f;
  std::array<float, kTerms> t{1.0f, x};
  for (size_t i = 2; i < kTerms; ++i) {
    t[i] = 2.0f * x * t[i - 1] - t[i - 2];
  }
  return t;
}

template <int kTerms>
float polynomial(const float* coefficients, float roughness, float cosine) {
  const auto rows = chebyshev<kTerms>(roughness), columns = chebyshev<kTerms>(cosine);
  float sum = 0.0f;
  for (size_t r = 0; r < kTerms; ++r) {
    for (size_t c = 0; c < kTerms; ++c) {
      sum += coefficients[r * kTerms + c] * rows[r] * columns[c];
    }
  }
  return sum;
}

// The polynomials on the grid where they were fitted; they are too long for each ray.
struct SheenTables {
  std::array<float, kSize * kSize> a, b, albedo;

  SheenTables() {
    // Smaller roughness was not fitted: there is next to no sheen, fading out to none.
    constexpr int kFirstRow = 2;
    for (int y = 0; y < kSize; ++y) {
      const float roughness = static_cast<float>(std::max(y, kFirstRow)) / (kSize - 1);
      const float fade = std::min(static_cast<float>(y) / kFirstRow, 1.0f);
      for (int x = 0; x < kSize; ++x) {
        const float cosine = static_cast<float>(x) / (kSize - 1);
        const auto i = static_cast<size_t>(y * kSize + x);
        // The transform may not degenerate: 0.03 is about the least of the published ones.
        a[i] = std::max(polynomial<kSheenATerms>(kSheenA, roughness, cosine), 0.03f);
        b[i] = polynomial<kSheenBTerms>(kSheenB, roughness, cosine);
        albedo[i] = fade * saturate(polynomial<kSheenAlbedoTerms>(kSheenAlbedo, roughness, cosine));
      }
    }
  }
};

const SheenTables sheen_tables;

}  // namespace

SheenTransform sheen_transform(float cos_v, float roughness) {
  return {lookup_2d<kSize>(sheen_tables.a.data(), cos_v, roughness),
          lookup_2d<kSize>(sheen_tables.b.data(), cos_v, roughness),
          lookup_2d<kSize>(sheen_tables.albedo.data(), cos_v, roughness)};
}

}  // namespace vernier
