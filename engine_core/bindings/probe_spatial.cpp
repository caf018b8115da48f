// Probes of the spatial indices.
#include <nanobind/ndarray.h>
#include <nanobind/stl/pair.h>

#include <span>
#include <vector>

#include "bindings/bind.h"
#include "bindings/table.h"
#include "spatial/hash_grid.h"

namespace nb = nanobind;

namespace vernier {
namespace {

static_assert(sizeof(Vec3f) == 3 * sizeof(float));

std::span<const Vec3f> points_of(const Rows3& rows) {
  return {reinterpret_cast<const Vec3f*>(rows.data()), rows.shape(0)};
}

using Indices = nb::ndarray<nb::numpy, uint32_t>;

Indices release(std::vector<uint32_t>&& values) {
  auto* kept = new std::vector<uint32_t>(std::move(values));
  const nb::capsule owner(kept,
                          [](void* p) noexcept { delete static_cast<std::vector<uint32_t>*>(p); });
  return Indices(kept->data(), {kept->size()}, owner);
}

// How many points each query visits, and which, query by query in the order of the visits.
std::pair<Indices, Indices> visited_by_grid(const HashGrid& grid, const Rows3& queries) {
  std::vector<uint32_t> counts, found;
  for (const Vec3f& q : points_of(queries)) {
    const size_t before = found.size();
    grid.for_each(q, [&](uint32_t index, float) { found.push_back(index); });
    counts.push_back(static_cast<uint32_t>(found.size() - before));
  }
  return {release(std::move(counts)), release(std::move(found))};
}

}  // namespace

void bind_spatial_probes(nb::module_& m) {
  nb::class_<HashGrid>(m, "HashGrid")
      .def(
          "__init__",
          [](HashGrid* grid, const Rows3& points, float radius, int threads) {
            new (grid) HashGrid(points_of(points), radius, threads);
          },
          nb::arg("points"), nb::arg("radius"), nb::arg("threads") = 0)
      .def("visit", &visited_by_grid)
      .def_prop_ro("memory", &HashGrid::memory);
}

}  // namespace vernier
