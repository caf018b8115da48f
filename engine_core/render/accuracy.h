// The statement of a picture's accuracy: its one definition.
//
// A render is a sequence of batches. From batch means m_b of n_b samples each,
//   m = sum n_b m_b / N,   s^2 = sum n_b (m_b - m)^2 / (B - 1),   standard error = sqrt(s^2 / N),
// which estimates N times the variance of m for independent batches, whatever correlates the
// samples within one. The batches of a camera integrator are consecutive blocks of one scrambled
// net: each fills the gaps of the others, so the true error is smaller than stated where the
// picture is smooth (the statement is then on the safe side), and as stated where noise comes from
// rare paths. A pixel's error is the half-width of its 95 % confidence interval relative to its
// value, or to 1 % of the picture's mean luminance where that is more. A picture's error is the
// 95th percentile of its pixels' errors.
#pragma once

#include <span>
#include <vector>

namespace vernier {

inline constexpr double kConfidence = 0.95;
inline constexpr double kErrorFloor = 0.01;  // of the mean luminance
inline constexpr double kErrorPercentile = 0.95;

// Half-width of the 95 % interval of a normal mean in standard errors that are themselves
// estimated from `batches` batches: Student's quantile with batches - 1 degrees of freedom.
// Infinite below 2 batches.
double interval_factor(unsigned batches);

// Standard error of a mean from the sums over batches: n = sum n_b, sum = sum n_b m_b,
// squares = sum n_b m_b^2. Infinite below 2 batches.
double standard_error(double n, double sum, double squares, unsigned batches);

// A pixel's relative error, by the definition above. `value` and `mean` are luminances.
double relative_error(double value, double half_width, double mean);

// The picture's error: the 95th percentile of its pixels'. Reorders `errors`. Infinite for none:
// nothing is known of that picture.
double picture_error(std::vector<float>& errors);

}  // namespace vernier
