#include "accuracy/statement.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace vernier {

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
