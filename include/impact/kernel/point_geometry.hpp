#pragma once
#include <impact/kernel/point_map.hpp>

/// Gradients of the shape functions at one point, for weak forms that take each of them several times.
namespace impact {

/// At one point (or the centroid): gradients of the shape functions, N_a/R of the axisymmetric frame, dV_0.
template <class Cell, Frame frame> struct PointGeometry {
  Vector<Batch, Cell::dim> dN[Cell::nodes];
  Batch ring[frame == Frame::axisymmetric ? Cell::nodes : 1];
  Batch weight;
};

/// dN is the table of reference derivatives, N the shape functions and w the weight of the point.
template <class Cell, Frame frame>
inline void point_geometry(const Batch* X, const double (&N)[Cell::nodes],
                           const double (&dN)[Cell::nodes][Cell::dim], double w,
                           PointGeometry<Cell, frame>& out) {
  constexpr int d = Cell::dim;
  Batch jacobian[d * d]; // dX_i / dxi_j
  reference_gradient<Cell, d>(dN, X, jacobian);
  PointMap<Cell, frame> map;
  point_map<Cell, frame>(X, jacobian, N, w, map);
  for (int a = 0; a < Cell::nodes; ++a)
    for (int i = 0; i < d; ++i)
      out.dN[a][i] = sum<d>([&](int j) { return dN[a][j] * map.inverse[j * d + i]; });
  out.weight = map.weight;
  if constexpr (frame == Frame::axisymmetric)
    for (int a = 0; a < Cell::nodes; ++a) out.ring[a] = N[a] * map.inverse_R;
}

template <class Cell, Frame frame> inline PointGeometry<Cell, frame> point_geometry(const Batch* X, int q) {
  const auto& t = shape_table<Cell>;
  PointGeometry<Cell, frame> out;
  point_geometry<Cell, frame>(X, t.N[q], t.dN[q], t.weight[q], out);
  return out;
}

template <class Cell, Frame frame>
inline Vector<Batch, Cell::dim> gradient_of_scalar(const PointGeometry<Cell, frame>& g, const Batch* nodal) {
  Vector<Batch, Cell::dim> r;
  for (int i = 0; i < Cell::dim; ++i) r[i] = sum<Cell::nodes>([&](int a) { return g.dN[a][i] * nodal[a]; });
  return r;
}

/// Grad u, with u_R/R in the 33 component of the axisymmetric frame.
template <class Cell, Frame frame>
inline Tensor<Batch, Cell::dim> gradient_of_vector(const PointGeometry<Cell, frame>& g, const Batch* nodal) {
  constexpr int d = Cell::dim;
  Tensor<Batch, d> H;
  for (int i = 0; i < d; ++i)
    for (int j = 0; j < d; ++j)
      H[d * i + j] = sum<Cell::nodes>([&](int a) { return nodal[a * d + i] * g.dN[a][j]; });
  if constexpr (d == 2) {
    H[4] = Batch(0.0);
    if constexpr (frame == Frame::axisymmetric)
      for (int a = 0; a < Cell::nodes; ++a) H[4] += nodal[a * d] * g.ring[a];
  }
  return H;
}

} // namespace impact
