#pragma once
#include <impact/element/cells.hpp>
#include <impact/math/batch.hpp>

namespace impact {

/// The mass of a cell that lumping puts on its nodes: int rho N_a dV_0. In second-order cells, where that is
/// nothing or less at the corners, int rho N_a^2 dV_0, scaled to the mass of the cell (E. Hinton, T. Rock,
/// O. Zienkiewicz, Earthq. Engng Struct. Dyn. 4 (1976) 245).
template <class Cell> struct LumpedMass {
  Batch at[Cell::nodes];
  Batch all = Batch(0.0);

  LumpedMass() {
    for (Batch& mass : at) mass = Batch(0.0);
  }
  /// Of a point with dV_0 = w.
  void add(int q, double rho, const Batch& w) {
    const auto& N = shape_table<Cell>.N[q];
    for (int a = 0; a < Cell::nodes; ++a) at[a] += (rho * (is_second_order<Cell> ? N[a] * N[a] : N[a])) * w;
    if constexpr (is_second_order<Cell>) all += rho * w;
  }
  /// After the last point.
  void finish() {
    if constexpr (!is_second_order<Cell>) return;
    Batch sum = at[0];
    for (int a = 1; a < Cell::nodes; ++a) sum += at[a];
    for (Batch& mass : at) mass *= all / sum;
  }
};

} // namespace impact
