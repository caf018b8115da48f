// Whether a picture has the accuracy that was asked for, to be asked more than once.
//
// A render that looks often and stops at the first good look would stop where chance was kind. So
// each look counts with a bound on the picture's error, not with the estimate: look number j may be
// wrong with probability 6 alpha / (pi j)^2, which sums to alpha = 5 % over all looks there may
// ever be. And looks are few: samples grow by an eighth at least from one to the next. A picture of
// which too little is known is refused, whatever its pixels say: see meets().
#pragma once

#include <span>
#include <vector>

#include "accuracy/pixel_sums.h"

namespace vernier {

// Batches that every pixel must have before any target is met.
inline constexpr unsigned kLeastBatches = 16;

struct Certificate {
  double error = 0;  // of the picture (statement.h)
  double bound = 0;  // of that error, by this look's share of confidence
  // Half-width of the 95 % confidence interval of the picture's mean, relative to it.
  double mean_error = 0;
  // How many pixels' worth carry the variance of the mean: (sum v)^2 / sum v^2.
  double carriers = 0;
  unsigned batches = 0;  // least number of any pixel
};

// `errors`: picture_errors() of `pixels`, whose mean luminance is `mean`. `look` counts from 1.
Certificate certify(std::span<const PixelEstimate> pixels, std::vector<float> errors, double mean,
                    unsigned batches, unsigned look);

// True when `target` is reached: the bound is below it, there are batches enough for a variance,
// and the mean of the picture, whose error rare bright paths dominate, is known better than the
// target; three times better where so few pixels carry its variance that this is a guess itself.
bool meets(const Certificate& certificate, double target);

}  // namespace vernier
