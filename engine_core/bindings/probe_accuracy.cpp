// Probes of batches and of the statement of accuracy.
#include <nanobind/stl/array.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <tuple>
#include <vector>

#include "accuracy/error_map.h"
#include "accuracy/picture_error.h"
#include "accuracy/statement.h"
#include "bindings/bind.h"
#include "render/batch_plan.h"

namespace nb = nanobind;

namespace vernier {
namespace {

// By batch: seed, first, samples, point, log2 of the net's room, second net.
std::vector<std::tuple<uint64_t, uint32_t, uint32_t, uint32_t, int, bool>> planned_batches(
    uint64_t seed, uint32_t samples, uint32_t planned, uint32_t share, bool single) {
  std::vector<std::tuple<uint64_t, uint32_t, uint32_t, uint32_t, int, bool>> rows;
  const BatchPlan plan(seed, samples, planned, {share, single});
  for (uint64_t i = 0; i < plan.size(); ++i) {
    const Batch b = plan[i];
    rows.emplace_back(b.seed, b.first, b.samples, b.point, b.log2_capacity, b.second_net);
  }
  return rows;
}

// Mean, variance, net_gap, excess and steady variance of a pixel whose batches, which alternate
// between the nets, have these sums and sizes.
std::array<double, 5> pixel_estimate(const std::vector<double>& sums,
                                     const std::vector<uint32_t>& sizes) {
  PixelSums pixel;
  BatchCounts counts;
  double total = 0.0;
  for (size_t b = 0; b < sums.size(); ++b) {
    const bool second = b % 2 == 1;
    pixel.add(sums[b], sizes.at(b), second, total, counts.samples);
    counts.add(sizes[b], second);
    total += sums[b];
  }
  const PixelEstimate e = pixel.estimate(total, counts);
  return {e.mean, e.variance, e.net_gap, e.excess, e.steady_variance};
}

// From rows of mean, variance, net_gap, excess, steady variance.
std::vector<float> error_map(const std::vector<std::array<double, 5>>& rows, int width, int height,
                             double mean) {
  std::vector<PixelEstimate> pixels;
  for (const auto& [mean, variance, net_gap, excess, steady] : rows) {
    pixels.push_back({mean, variance, net_gap, excess, steady});
  }
  return half_widths(pixels, width, height, mean);
}

// From the same rows: the errors of all neighbourhoods, and the picture's.
std::tuple<std::vector<float>, double> whole_picture(const std::vector<std::array<double, 5>>& rows,
                                                     int width, int height, double mean) {
  std::vector<PixelEstimate> pixels;
  for (const auto& [mean, variance, net_gap, excess, steady] : rows) {
    pixels.push_back({mean, variance, net_gap, excess, steady});
  }
  std::vector<float> errors = picture_errors(pixels, width, height, mean).errors;
  const std::vector<float> kept = errors;
  return {kept, picture_error(errors)};
}

}  // namespace

void bind_accuracy_probes(nb::module_& m) {
  m.def("batch_samples", &batch_samples, nb::arg("total_before"), nb::arg("share") = 4);
  m.def("plan_batches", &planned_batches);
  m.def("pixel_estimate", &pixel_estimate);
  m.def("half_widths", &error_map);
  m.def("picture_errors", &whole_picture);
  m.def("relative_error", &relative_error);
  m.def("picture_error", [](std::vector<float> errors) { return picture_error(errors); });
}

}  // namespace vernier
