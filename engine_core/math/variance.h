// The variance of numbers that come one by one.
#pragma once

#include <algorithm>

namespace vernier {

// For statistics that steer a render: numbers whose spread is far below their mean lose digits to
// cancellation.
class Variance {
 public:
  void add(double value) {
    sum_ += value;
    squares_ += value * value;
    count_ += 1.0;
  }
  // Not negative; NaN of no numbers.
  double value() const {
    const double mean = sum_ / count_;
    return std::max(squares_ / count_ - mean * mean, 0.0);
  }

 private:
  double sum_ = 0.0, squares_ = 0.0, count_ = 0.0;
};

}  // namespace vernier
