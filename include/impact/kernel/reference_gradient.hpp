#pragma once
#include <impact/element/cells.hpp>
#include <impact/math/batch.hpp>
#include <impact/math/index.hpp>

/// Gradients of nodal fields with respect to the reference coordinates xi at all points of a cell at once,
/// and the transpose, which turns fluxes at the points into nodal forces.
///
/// On linear simplices the gradient is constant. Other cells take the sum over their nodes, but
/// quadrilaterals and hexahedra with the 2-point Gauss product pass through the polynomial modes of the cell,
/// v(xi) = sum_a m_a prod_k xi_k over the directions k in which node a lies at xi_k = +1. Nodes -> modes and
/// modes -> points are sums and differences of pairs along one direction after the other: 55 operations per
/// component of a hexahedron where sums over the nodes at every point take 192.
namespace impact {

template <class Cell> inline constexpr bool is_simplex = Cell::nodes == Cell::dim + 1;

/// Whether the cell is a product of lines and its points are those of the 2-point Gauss rule, in the order of
/// the nodes.
template <class Cell> constexpr bool has_modes() {
  if constexpr (requires { Cell::sign; }) {
    bool same = Cell::points == Cell::nodes && Cell::nodes == 1 << Cell::dim;
    for (int q = 0; same && q < Cell::points; ++q)
      for (int k = 0; k < Cell::dim; ++k)
        same = same && Cell::point(q)[unsigned(k)] == Quad4::gauss * Cell::sign[q][k];
    return same;
  }
  return false;
}

/// Whether node a lies at the + end of direction k.
template <class Cell> constexpr bool at_end(int a, int k) { return Cell::sign[a][k] > 0; }

/// The node at the other end of the edge along direction k.
template <class Cell> constexpr int across(int a, int k) {
  int other = a;
  for (int b = 0; b < Cell::nodes; ++b) {
    bool is_other = true;
    for (int l = 0; l < Cell::dim; ++l)
      is_other = is_other && (at_end<Cell>(a, l) == at_end<Cell>(b, l)) == (l != k);
    if (is_other) other = b;
  }
  return other;
}

/// What a derivative of mode a is multiplied by at the points: 2^-dim from the shape functions, and |xi| of
/// the points for every direction of the mode but the differentiated one.
template <class Cell> constexpr double mode_scale(int a) {
  double scale = 1;
  int directions = 0;
  for (int k = 0; k < Cell::dim; ++k) {
    scale *= 0.5;
    if (at_end<Cell>(a, k) && ++directions > 1) scale *= Quad4::gauss;
  }
  return scale;
}

/// (v-, v+) -> (v- + v+, v+ - v-) for the pairs along direction k; only the modes of direction `of` where
/// given.
template <class Cell, int k, int of = k> inline void sums_and_differences(Batch* v) {
  unroll<Cell::nodes>([&](auto node) {
    constexpr int a = node, b = across<Cell>(a, k);
    if constexpr (at_end<Cell>(a, k) && at_end<Cell>(a, of)) {
      const Batch both = v[b] + v[a];
      v[a] = v[a] - v[b];
      v[b] = both;
    }
  });
}

/// The transpose: (even, odd) -> (even - odd, even + odd).
template <class Cell, int k, int of = k> inline void values_at_ends(Batch* v) {
  unroll<Cell::nodes>([&](auto node) {
    constexpr int a = node, b = across<Cell>(a, k);
    if constexpr (at_end<Cell>(a, k) && at_end<Cell>(a, of)) {
      const Batch end = v[b] + v[a];
      v[b] = v[b] - v[a];
      v[a] = end;
    }
  });
}

/// Both ways for a cell with modes. Bodies of code of their own, which all weak forms share: as a part of
/// each they would take the compiler as long as a law does.
template <class Cell, int components>
[[gnu::noinline]] void gradients_by_modes(const Batch* nodal, Batch (*out)[components * Cell::dim]) {
  constexpr int d = Cell::dim;
  for (int i = 0; i < components; ++i) {
    Batch mode[Cell::nodes];
    unroll<Cell::nodes>([&](auto a) { mode[a] = nodal[a * components + i]; });
    unroll<d>([&](auto k) { sums_and_differences<Cell, k>(mode); });
    unroll<Cell::nodes>([&](auto a) { mode[a] *= Batch(mode_scale<Cell>(a)); });
    unroll<d>([&](auto direction) {
      constexpr int k = direction;
      Batch slope[Cell::nodes];
      unroll<Cell::nodes>([&](auto a) { slope[a] = mode[a]; });
      unroll<d>([&](auto l) {
        if constexpr (l != k) values_at_ends<Cell, l, k>(slope);
      });
      unroll<Cell::nodes>([&](auto point) { // the derivative does not vary along its own direction
        constexpr int q = point;
        out[q][i * d + k] = slope[at_end<Cell>(q, k) ? q : across<Cell>(q, k)];
      });
    });
  }
}

template <class Cell, int components>
[[gnu::noinline]] void add_forces_by_modes(const Batch (*flux)[components * Cell::dim], Batch* nodal) {
  constexpr int d = Cell::dim;
  for (int i = 0; i < components; ++i) {
    Batch mode[Cell::nodes];
    unroll<Cell::nodes>([&](auto a) { mode[a] = Batch(0.0); });
    unroll<d>([&](auto direction) {
      constexpr int k = direction;
      Batch part[Cell::nodes];
      unroll<Cell::nodes>([&](auto point) {
        constexpr int q = point, other = across<Cell>(q, k);
        if constexpr (at_end<Cell>(q, k)) part[q] = flux[q][i * d + k] + flux[other][i * d + k];
      });
      unroll<d>([&](auto l) {
        if constexpr (l != k) sums_and_differences<Cell, l, k>(part);
      });
      unroll<Cell::nodes>([&](auto a) {
        if constexpr (at_end<Cell>(a, k)) mode[a] += part[a];
      });
    });
    unroll<Cell::nodes>([&](auto a) { mode[a] *= Batch(mode_scale<Cell>(a)); });
    unroll<d>([&](auto k) { values_at_ends<Cell, k>(mode); });
    unroll<Cell::nodes>([&](auto a) { nodal[a * components + i] += mode[a]; });
  }
}

/// out[point][i * dim + k] = dv_i/dxi_k for the nodal field v [node][components].
template <class Cell, int components>
inline void reference_gradients(const Batch* nodal, Batch (*out)[components * Cell::dim]) {
  constexpr int d = Cell::dim;
  if constexpr (has_modes<Cell>()) return gradients_by_modes<Cell, components>(nodal, out);
  for (int i = 0; i < components; ++i)
    for (int k = 0; k < d; ++k)
      for (int q = 0; q < Cell::points; ++q)
        if constexpr (is_simplex<Cell>)
          out[q][i * d + k] = nodal[(k + 1) * components + i] - nodal[i];
        else
          out[q][i * d + k] = sum<Cell::nodes>(
              [&](int a) { return shape_table<Cell>.dN[q][a][k] * nodal[a * components + i]; });
}

/// nodal[a][i] += sum over the points of flux[point][i * dim + k] dN_a/dxi_k.
template <class Cell, int components>
inline void add_nodal_forces(const Batch (*flux)[components * Cell::dim], Batch* nodal) {
  constexpr int d = Cell::dim;
  if constexpr (has_modes<Cell>()) return add_forces_by_modes<Cell, components>(flux, nodal);
  for (int i = 0; i < components; ++i)
    if constexpr (is_simplex<Cell>) {
      for (int k = 0; k < d; ++k) {
        const Batch force = sum<Cell::points>([&](int q) { return flux[q][i * d + k]; });
        nodal[(k + 1) * components + i] += force;
        nodal[i] -= force;
      }
    } else {
      for (int q = 0; q < Cell::points; ++q)
        for (int a = 0; a < Cell::nodes; ++a)
          for (int k = 0; k < d; ++k)
            nodal[a * components + i] += shape_table<Cell>.dN[q][a][k] * flux[q][i * d + k];
    }
}

} // namespace impact
