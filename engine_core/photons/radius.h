// How the radius of progressive methods shrinks.
#pragma once

#include <cmath>
#include <cstdint>

namespace vernier {

// The radius of pass `pass` (0: the first) over that of the first, where each pass estimates alone
// and the picture is their mean: r_{i+1}^2 = r_i^2 (i + alpha) / (i + 1) (Knaus and Zwicker 2011,
// "Progressive Photon Mapping: A Probabilistic Approach", equation 15). Passes know nothing of each
// other, so that they are independent samples. alpha in (0, 1): the mean's variance falls as
// N^-alpha and its squared bias as N^(2 alpha - 2); both fall alike, and their sum fastest, at 2/3
// (Kaplanyan and Dachsbacher 2013). At 1 the radius stays.
inline float progressive_radius(uint64_t pass, double alpha) {
  // The product over i from 1 to `pass`, by the gamma function.
  const auto n = static_cast<double>(pass) + 1.0;
  return static_cast<float>(
      std::exp(0.5 * (std::lgamma(n + alpha) - std::lgamma(1.0 + alpha) - std::lgamma(n + 1.0))));
}

}  // namespace vernier
