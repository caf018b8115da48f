// What the probes give to Python: float arrays of rows and columns.
#pragma once

#include <nanobind/ndarray.h>

#include <cstddef>
#include <utility>

#include "math/vec.h"

namespace vernier {

using Rows2 = nanobind::ndarray<const float, nanobind::shape<-1, 2>, nanobind::c_contig,
                                nanobind::device::cpu>;
using Rows3 = nanobind::ndarray<const float, nanobind::shape<-1, 3>, nanobind::c_contig,
                                nanobind::device::cpu>;
using Result = nanobind::ndarray<nanobind::numpy, float>;

// A float array of (rows, columns), zero at first, that Python owns once it is released.
class Table {
 public:
  Table(size_t rows, size_t columns)
      : rows_(rows),
        columns_(columns),
        data_(new float[rows * columns]()),
        owner_(data_, [](void* p) noexcept { delete[] static_cast<float*>(p); }) {}

  size_t rows() const { return rows_; }
  float* row(size_t i) const { return data_ + i * columns_; }
  Result release() const { return Result(data_, {rows_, columns_}, owner_); }

 private:
  size_t rows_, columns_;
  float* data_;
  nanobind::capsule owner_;
};

inline void write(Vec3f v, float* out) { out[0] = v.x, out[1] = v.y, out[2] = v.z; }

}  // namespace vernier
