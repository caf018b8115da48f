#include "accuracy/certificate.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "accuracy/statement.h"

namespace vernier {
namespace {

constexpr double kLeastCarriers = 16.0;
constexpr double kFewCarriersFactor = 3.0;
// Errors of neighbours say the same: half of each is pooled over 7 x 7 pixels.
constexpr double kPixelsPerValue = 25.0;

// The normal distribution's quantile above which lies the probability p < 0.5, within 5e-4
// (Abramowitz and Stegun 26.2.23).
double upper_quantile(double p) {
  const double t = std::sqrt(-2.0 * std::log(p));
  return t - (2.515517 + t * (0.802853 + t * 0.010328)) /
                 (1.0 + t * (1.432788 + t * (0.189269 + t * 0.001308)));
}

}  // namespace

Certificate certify(std::span<const PixelEstimate> pixels, std::vector<float> errors, double mean,
                    unsigned batches, unsigned look) {
  Certificate c;
  c.batches = batches;
  double sum = 0.0, squares = 0.0;
  for (const PixelEstimate& p : pixels) {
    sum += p.variance, squares += p.variance * p.variance;
  }
  const auto count = static_cast<double>(pixels.size());
  c.carriers = squares > 0.0 ? sum * (sum / squares) : count;
  c.mean_error = relative_error(mean, 2.0 * std::sqrt(sum) / count, mean);
  const double share =
      6.0 * (1.0 - kConfidence) / (std::numbers::pi * std::numbers::pi * look * look);
  // A quantile's rank is binomial.
  const double spread = std::sqrt(kErrorPercentile * (1.0 - kErrorPercentile) * kPixelsPerValue /
                                  std::max(count, 1.0));
  c.bound = error_percentile(errors, kErrorPercentile + upper_quantile(share) * spread);
  c.error = picture_error(errors);
  return c;
}

bool meets(const Certificate& c, double target) {
  const double factor = c.carriers < kLeastCarriers ? kFewCarriersFactor : 1.0;
  return c.batches >= kLeastBatches && c.bound <= target && factor * c.mean_error <= target;
}

}  // namespace vernier
