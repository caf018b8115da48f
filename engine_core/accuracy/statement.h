// The statement of a picture's accuracy: its one definition.
//
// A render is a sequence of batches; pixel_sums.h tells what one pixel's say of its error. A
// pixel's error is the half-width of its 95 % confidence interval relative to its value, or to 1 %
// of the picture's mean luminance where that is more. A picture's error is the 95th percentile of
// its pixels' errors. Both are estimates: error_map.h has that of each pixel, which is careful for
// its own sake, and picture_error.h that of the picture, which knows more than any pixel does.
#pragma once

#include <vector>

namespace vernier {

inline constexpr double kConfidence = 0.95;
inline constexpr double kErrorFloor = 0.01;  // of the mean luminance
inline constexpr double kErrorPercentile = 0.95;

// A pixel's relative error, by the definition above. `value` and `mean` are luminances.
double relative_error(double value, double half_width, double mean);

// The least error that a share of the pixels does not exceed; of all, for a share of 1 or more.
// Reorders `errors`. Infinite for none: nothing is known of that picture.
double error_percentile(std::vector<float>& errors, double share);

// The picture's error: the 95th percentile of its pixels'. Reorders `errors`. Infinite for none:
// nothing is known of that picture.
double picture_error(std::vector<float>& errors);

}  // namespace vernier
