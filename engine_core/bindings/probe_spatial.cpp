// Probes of the spatial indices.
#include <nanobind/ndarray.h>
#include <nanobind/stl/pair.h>

#include <span>
#include <vector>

#include "bindings/bind.h"
#include "bindings/table.h"
#include "spatial/hash_grid.h"
#include "spatial/kd_tree.h"

namespace nb = nanobind;

namespace vernier {
namespace {

static_assert(sizeof(Vec3f) == 3 * sizeof(float));

std::span<const Vec3f> points_of(const Rows3& rows) {
  return {reinterpret_cast<const Vec3f*>(rows.data()), rows.shape(0)};
}

using Indices = nb::ndarray<nb::numpy, uint32_t>;

Indices release(std::vector<uint32_t>&& values, size_t columns = 0) {
  auto* kept = new std::vector<uint32_t>(std::move(values));
  const nb::capsule owner(kept,
                          [](void* p) noexcept { delete static_cast<std::vector<uint32_t>*>(p); });
  return columns == 0 ? Indices(kept->data(), {kept->size()}, owner)
                      : Indices(kept->data(), {kept->size() / columns, columns}, owner);
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

// The same for all points of a tree within one radius.
std::pair<Indices, Indices> visited_by_tree(const KdTree& tree, const Rows3& queries,
                                            float radius) {
  std::vector<uint32_t> counts, found;
  for (const Vec3f& q : points_of(queries)) {
    const size_t before = found.size();
    tree.for_each(q, square(radius),
                  [&](uint32_t place, float) { found.push_back(tree.index(place)); });
    counts.push_back(static_cast<uint32_t>(found.size() - before));
  }
  return {release(std::move(counts)), release(std::move(found))};
}

// Indices and distances of the k nearest, a row per query; infinite where there are no more.
nb::tuple nearest_in_tree(const KdTree& tree, const Rows3& queries, size_t k, float radius) {
  const std::span<const Vec3f> points = points_of(queries);
  const Table distances(points.size(), k);
  std::vector<uint32_t> indices(points.size() * k);
  std::vector<KdNeighbour> found(k);
  for (size_t i = 0; i < points.size(); ++i) {
    const size_t count = tree.nearest(points[i], k, square(radius), found);
    for (size_t j = 0; j < k; ++j) {
      const bool there = j < count;
      distances.row(i)[j] = there ? std::sqrt(found[j].distance_squared) : kInfinity;
      indices[i * k + j] = there ? tree.index(found[j].place) : 0;
    }
  }
  return nb::make_tuple(release(std::move(indices), k), distances.release());
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
  nb::class_<KdTree>(m, "KdTree")
      .def(
          "__init__",
          [](KdTree* tree, const Rows3& points, int threads) {
            new (tree) KdTree(points_of(points), threads);
          },
          nb::arg("points"), nb::arg("threads") = 0)
      .def("within", &visited_by_tree)
      .def("nearest", &nearest_in_tree)
      .def_prop_ro("memory", &KdTree::memory);
}

}  // namespace vernier
