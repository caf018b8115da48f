#include "lights/environment.h"

#include <algorithm>
#include <vector>

#include "lights/lamp.h"
#include "math/parallel.h"

namespace vernier {

EnvironmentMap::EnvironmentMap(int resolution, int points, bool even,
                               const std::function<Color(Vec3f)>& radiance)
    : uniform_(false), even_(even) {
  const int fine = points * resolution;
  const float share = 1.0f / static_cast<float>(points * points);
  std::vector<float> cells(static_cast<size_t>(resolution) * static_cast<size_t>(resolution));
  std::vector<double> sums(static_cast<size_t>(resolution));  // by row: added in order below
  parallel_for(sums.size(), 0, [&](size_t row) {
    for (int i = 0; i < points * fine; ++i) {
      const int x = i % fine, y = points * static_cast<int>(row) + i / fine;
      const Vec2f p{(static_cast<float>(x) + 0.5f) / static_cast<float>(fine),
                    (static_cast<float>(y) + 0.5f) / static_cast<float>(fine)};
      const float value =
          share *
          average(bounded_radiance(abs(radiance(normalize(square_to_sphere_equal_area(p))))));
      if (value > 0.0f) {
        cells[row * static_cast<size_t>(resolution) + static_cast<size_t>(x / points)] += value;
        sums[row] += static_cast<double>(value);
      }
    }
  });
  double sum = 0.0;
  for (const double row : sums) {
    sum += row;
  }
  mean_ = static_cast<float>(sum / static_cast<double>(cells.size()));
  map_ = PiecewiseConstant2D(cells, resolution, resolution);
  if (even_) {
    keep_peaks(cells, resolution);
  }
}

void EnvironmentMap::keep_peaks(std::vector<float>& cells, int resolution) {
  double sum = 0.0;
  for (float& cell : cells) {
    cell = std::max(cell - mean_, 0.0f);
    sum += static_cast<double>(cell);
  }
  // What exceeds the mean by less than this part of it may be rounding, of a plain picture.
  constexpr float kLeastPeaks = 1e-5f;
  const auto mean_of_peaks = static_cast<float>(sum / static_cast<double>(cells.size()));
  if (mean_of_peaks > kLeastPeaks * mean_) {
    share_of_peaks_ = mean_of_peaks / mean_;
    peaks_ = PiecewiseConstant2D(cells, resolution, resolution);
  }
}

Vec3f EnvironmentMap::sample_map(const PiecewiseConstant2D& map, Vec2f u, float& pdf) {
  const Vec2f p = map.sample(u, pdf);
  pdf *= kInvFourPi;
  return normalize(square_to_sphere_equal_area(p));
}

float EnvironmentMap::pdf_map(const PiecewiseConstant2D& map, Vec3f wi) {
  return map.pdf(sphere_to_square_equal_area(wi)) * kInvFourPi;
}

Vec3f EnvironmentMap::sample_direction(Vec2f u, float& pdf) const {
  if (uniform_) {
    pdf = kInvFourPi;
    return square_to_uniform_sphere(u);
  }
  return sample_map(map_, u, pdf);
}

float EnvironmentMap::pdf_direction(Vec3f wi) const {
  return uniform_ ? kInvFourPi : pdf_map(map_, wi);
}

}  // namespace vernier
