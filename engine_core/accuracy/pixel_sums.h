// What a pixel keeps of its batches for the error bar, besides its picture.
//
// Batches are independent or nearly so, of n_b samples each; s_b is the sum of a batch's samples'
// luminances, N = sum n_b, S = sum s_b, and m = S / N is the pixel's luminance.
//   v = sum (s_b - n_b m)^2 / (N^2 - sum n_b^2)
// estimates the variance of m for independent batches, whatever correlates the samples within one.
// It weighs a batch by all it brought: one rare bright path counts alike in a small batch and in a
// large one.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace vernier {

// What the batches of a pixel have in common with those of its whole tile.
struct BatchCounts {
  double samples_squared = 0;  // sum n_b^2
  uint32_t samples = 0;        // N
  uint32_t batches = 0;
  uint32_t second_net = 0;  // samples of the second net

  void add(uint32_t n, bool second) {
    samples_squared += static_cast<double>(n) * n;
    samples += n;
    ++batches;
    second_net += second ? n : 0;
  }
};

// What is known of a pixel by itself. All are luminances.
struct PixelEstimate {
  double mean = std::numeric_limits<double>::quiet_NaN();     // NaN: it has no samples
  double variance = std::numeric_limits<double>::infinity();  // of the mean; infinite: not known
  // Half the difference between the two nets' means, squared: it has the variance of the mean,
  // within a net's points' gain over independent ones; NaN: not known.
  double net_gap = std::numeric_limits<double>::quiet_NaN();
  // What a single batch that stands out added to the mean; 0: none does.
  double excess = 0;
  double steady_variance = variance;  // of the mean, without that batch
};

class PixelSums {
 public:
  // A batch whose luminances sum to `sum`.
  void add(double sum, uint32_t n, bool second, double total_before, uint32_t samples_before) {
    squares_ += sum * sum;
    cross_ += n * sum;
    second_ += second ? sum : 0.0;
    // The batch that exceeds the mean of the others most.
    const double rest = std::max(0.0, static_cast<double>(samples_before) - peak_samples_);
    const double mean = rest > 0.0 ? (total_before - peak_) / rest : 0.0;
    if (sum - n * mean > peak_ - peak_samples_ * mean) {
      peak_ = sum;
      peak_samples_ = n;
    }
  }

  PixelEstimate estimate(double sum, const BatchCounts& counts) const {
    PixelEstimate e;
    const double n = counts.samples;
    if (counts.samples == 0) {
      return e;
    }
    e.mean = sum / n;
    if (counts.batches < 2) {
      return e;
    }
    e.variance = variance(sum, n, counts.samples_squared, squares_, cross_);
    const double second = counts.second_net, first = n - second;
    if (first > 0.0 && second > 0.0) {
      const double gap = second_ / second - (sum - second_) / first;
      e.net_gap = gap * gap * (first * second / (n * n));
    }
    e.steady_variance = e.variance;
    if (counts.batches > 4) {
      set_apart_peak(sum, n, counts.samples_squared, e);
    }
    return e;
  }

 private:
  // A batch stands out where it exceeds the mean of the others by this many of their standard
  // deviations: fewer than one in a thousand of eight batches do by chance (Student's quantile).
  static constexpr double kStandsOut = 6.0;

  static double variance(double sum, double n, double samples_squared, double squares,
                         double cross) {
    const double m = sum / n;
    const double spread = squares - 2.0 * m * cross + m * m * samples_squared;
    return std::max(0.0, spread) / (n * n - samples_squared);
  }

  void set_apart_peak(double sum, double n, double samples_squared, PixelEstimate& e) const {
    const double k = peak_samples_, rest = n - k;
    const double over = peak_ - k * ((sum - peak_) / rest);
    const double others = variance(sum - peak_, rest, samples_squared - k * k,
                                   squares_ - peak_ * peak_, cross_ - k * peak_);
    // The variance of one sample is `others` times `rest`.
    if (over > kStandsOut * std::sqrt(k * rest * others)) {
      e.excess = over / n;
      e.steady_variance = others * (rest / n);
    }
  }

  double squares_ = 0;  // sum s_b^2
  double cross_ = 0;    // sum n_b s_b
  double second_ = 0;   // sum s_b over the second net
  double peak_ = 0;     // s_b of the batch that stands out most
  uint32_t peak_samples_ = 0;
};

}  // namespace vernier
