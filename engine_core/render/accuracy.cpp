#include "render/accuracy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace vernier {

double interval_factor(unsigned batches) {
  // 97.5 % quantiles of Student's t for 1 to 30 degrees of freedom.
  static constexpr std::array kQuantiles{
      12.7062, 4.3027, 3.1824, 2.7764, 2.5706, 2.4469, 2.3646, 2.3060, 2.2622, 2.2281,
      2.2010,  2.1788, 2.1604, 2.1448, 2.1314, 2.1199, 2.1098, 2.1009, 2.0930, 2.0860,
      2.0796,  2.0739, 2.0687, 2.0639, 2.0595, 2.0555, 2.0518, 2.0484, 2.0452, 2.0423};
  if (batches < 2) {
    return std::numeric_limits<double>::infinity();
  }
  const unsigned freedom = batches - 1;
  if (freedom <= kQuantiles.size()) {
    return kQuantiles[freedom - 1];
  }
  // Cornish-Fisher expansion about the normal quantile z (Abramowitz and Stegun 26.7.5).
  const double z = 1.959963984540054, n = freedom;
  const double z3 = z * z * z, z5 = z3 * z * z, z7 = z5 * z * z;
  return z + (z3 + z) / (4.0 * n) + (5.0 * z5 + 16.0 * z3 + 3.0 * z) / (96.0 * n * n) +
         (3.0 * z7 + 19.0 * z5 + 17.0 * z3 - 15.0 * z) / (384.0 * n * n * n);
}

double standard_error(double n, double sum, double squares, unsigned batches) {
  if (batches < 2) {
    return std::numeric_limits<double>::infinity();
  }
  const double spread = std::max(0.0, squares - sum * (sum / n));
  return std::sqrt(spread / (static_cast<double>(batches - 1) * n));
}

double relative_error(double value, double half_width, double mean) {
  const double scale = std::max(std::abs(value), kErrorFloor * std::abs(mean));
  if (scale > 0.0) {
    return half_width / scale;
  }
  return half_width > 0.0 ? std::numeric_limits<double>::infinity() : 0.0;
}

double picture_error(std::vector<float>& errors) {
  if (errors.empty()) {
    return std::numeric_limits<double>::infinity();
  }
  // The least error that 95 % of the pixels do not exceed.
  const double count = std::ceil(kErrorPercentile * static_cast<double>(errors.size()));
  const size_t rank = std::max<size_t>(static_cast<size_t>(count), 1) - 1;
  const auto at = errors.begin() + static_cast<ptrdiff_t>(rank);
  std::nth_element(errors.begin(), at, errors.end());
  return static_cast<double>(*at);
}

}  // namespace vernier
