#include "accuracy/error_map.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "accuracy/neighbourhood.h"
#include "accuracy/statement.h"

namespace vernier {
namespace {

constexpr double kOwnShare = 0.5;
constexpr int kNetRadius = 3;                 // cells
constexpr std::array kExcessRadii{1, 3, 12};  // cells

}  // namespace

std::vector<float> half_widths(PixelEstimates pixels, int width, int height, double mean) {
  const std::vector<double> levels =
      light_levels(pixels, width, height, kErrorFloor * std::abs(mean));
  const std::vector<double> pooled = pooled_variances(pixels, levels, width, height);
  const Cells cells(pixels, shared_excess(pixels, width, height), pooled, width, height);
  const std::vector<CellSums> nets = cells.around(kNetRadius);
  std::array<std::vector<CellSums>, kExcessRadii.size()> excesses;
  for (size_t k = 0; k < kExcessRadii.size(); ++k) {
    excesses[k] = cells.around(kExcessRadii[k]);
  }
  std::vector<float> widths(pixels.size());
  size_t i = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x, ++i) {
      const size_t cell = cells.index(x, y);
      double lacking = 0.0;
      for (const std::vector<CellSums>& sums : excesses) {
        lacking = std::max(lacking, sums[cell].most_lacking());
      }
      // A pixel that met such a batch lacks that much less: it has it in its variance.
      lacking = std::max(lacking - pixels[i].excess, 0.0);
      const double variance = kOwnShare * pixels[i].variance + (1.0 - kOwnShare) * pooled[i];
      const double random = kNormalQuantile * std::sqrt(variance * nets[cell].net_gain());
      // What is lacking is the same every time: it shifts what varies.
      widths[i] = static_cast<float>(random + lacking);
    }
  }
  return widths;
}

}  // namespace vernier
