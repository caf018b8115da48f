// Probes of Markov chains: on targets whose distribution is known.
#include <nanobind/stl/vector.h>

#include "bindings/bind.h"
#include "metropolis/metropolis_step.h"
#include "metropolis/primary_sample.h"
#include "metropolis/seed_pool.h"

namespace nb = nanobind;

namespace vernier {
namespace {

struct ToyState {
  int cell = 0;
  double target = 0;
};

// A chain of `steps` mutations over [0,1) in primary-sample space, whose target is constant in each
// of the cells. Its dimension is 1, where `dimensions` is 1, else one of two: the first choice says
// which pair of numbers the point is read from. (visits by chance, expected visits) by cell.
std::vector<std::vector<double>> toy_chain(const std::vector<double>& cells, uint64_t steps,
                                           double large_steps, int dimensions, uint64_t seed,
                                           uint64_t every) {
  PrimarySamples samples;
  samples.seed(seed);
  MarkovChain<ToyState> chain;
  const auto evaluate = [&](ToyState& state) {
    uint32_t dimension = 0;
    if (dimensions > 1) {
      dimension = samples.get(kFirstLightDimension).y < 0.5f ? 1 : 2;
    }
    const float u = samples.get(dimension).x;
    state.cell = static_cast<int>(u * static_cast<float>(cells.size()));
    state.target = cells[static_cast<size_t>(state.cell)] * (dimension == 2 ? 3.0 : 1.0);
  };
  samples.propose(true);
  evaluate(chain.current);
  while (!(chain.current.target > 0.0)) {
    samples.propose(true);
    evaluate(chain.current);
  }
  samples.accept();
  std::vector<double> chance(cells.size()), expected(cells.size());
  const auto record = [&](const ToyState& state, double visits) {
    expected[static_cast<size_t>(state.cell)] += visits;
  };
  for (uint64_t i = 0; i < steps; ++i) {
    samples.propose(static_cast<double>(samples.random()) < large_steps);
    evaluate(chain.proposed);
    if (metropolis_step(chain, 1.0, samples.random(), record)) {
      samples.accept();
    }
    if (i % every == 0) {
      chance[static_cast<size_t>(chain.current.cell)] += 1.0;
    }
  }
  end_chain(chain, record);
  return {chance, expected};
}

}  // namespace

void bind_metropolis_probes(nb::module_& m) {
  m.def("toy_chain", &toy_chain, nb::arg("cells"), nb::arg("steps"), nb::arg("large_steps"),
        nb::arg("dimensions"), nb::arg("seed"), nb::arg("every"));
  m.def("small_steps", [](const std::vector<float>& u, const std::vector<uint32_t>& bits) {
    std::vector<float> moved(u.size());
    for (size_t i = 0; i < u.size(); ++i) {
      moved[i] = small_step(u[i], bits[i]);
    }
    return moved;
  });
  m.def("acceptance", &acceptance);
  m.def("part_of", &part_of, nb::arg("u"), nb::arg("count"));
  m.def("point_of_part", &point_of_part, nb::arg("part"), nb::arg("count"), nb::arg("within"));
  m.def("choose_by_sums", &choose_by_sums, nb::arg("sums"), nb::arg("u"));
}

}  // namespace vernier
