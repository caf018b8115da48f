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

double error_percentile(std::vector<float>& errors, double share) {
  if (errors.empty()) {
    return std::numeric_limits<double>::infinity();
  }
  const auto size = static_cast<double>(errors.size());
  const double count = std::clamp(std::ceil(share * size), 1.0, size);
  const auto at = errors.begin() + static_cast<ptrdiff_t>(count) - 1;
  std::nth_element(errors.begin(), at, errors.end());
  return static_cast<double>(*at);
}

double picture_error(std::vector<float>& errors) {
  return error_percentile(errors, kErrorPercentile);
}

}  // namespace vernier
