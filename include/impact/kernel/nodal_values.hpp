#pragma once
#include <impact/element/cells.hpp>
#include <impact/math/batch.hpp>
#include <impact/math/index.hpp>

namespace impact {

/// dv_i/dxi_k, [i * dim + k], where the reference derivatives of the shape functions are dN.
template <class Cell, int components>
inline void reference_gradient(const double (&dN)[Cell::nodes][Cell::dim], const Batch* nodal, Batch* slope) {
  for (int i = 0; i < components; ++i)
    for (int k = 0; k < Cell::dim; ++k)
      slope[i * Cell::dim + k] =
          sum<Cell::nodes>([&](int a) { return dN[a][k] * nodal[a * components + i]; });
}

/// Component i of a nodal field of `components` at point q.
template <class Cell, int components = 1> inline Batch interpolate(const Batch* nodal, int q, int i = 0) {
  const auto& N = shape_table<Cell>.N[q];
  return sum<Cell::nodes>([&](int a) { return N[a] * nodal[a * components + i]; });
}

} // namespace impact
