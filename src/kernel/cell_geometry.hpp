#pragma once
#include <impact/element/shape.hpp>
#include <impact/kernel/frame.hpp>
#include <impact/math/batch.hpp>
#include <impact/math/tensor.hpp>

#include <numbers>

/// Reference gradients, weights and gradients of nodal fields of one batch of cells.
namespace impact {

/// At one point (or the centroid): gradients of the shape functions, N_a/R of the axisymmetric frame, dV_0.
template <class Cell, Frame frame> struct PointGeometry {
  Batch dN[Cell::nodes][Cell::dim];
  Batch ring[frame == Frame::axisymmetric ? Cell::nodes : 1];
  Batch weight;
};

/// dN is the table of reference derivatives, N the shape functions and w the weight of the point.
template <class Cell, Frame frame>
inline void point_geometry(const Batch* X, const double (&N)[Cell::nodes],
                           const double (&dN)[Cell::nodes][Cell::dim], double w,
                           PointGeometry<Cell, frame>& out) {
  constexpr int d = Cell::dim;
  Batch jacobian[d][d]; // dX_i / dxi_j
  for (int i = 0; i < d; ++i)
    for (int j = 0; j < d; ++j) {
      Batch s = dN[0][j] * X[i];
      for (int a = 1; a < Cell::nodes; ++a) s += dN[a][j] * X[a * d + i];
      jacobian[i][j] = s;
    }
  Batch inverse[d][d], det; // dxi_j / dX_i as inverse[j][i]
  if constexpr (d == 2) {
    det = jacobian[0][0] * jacobian[1][1] - jacobian[0][1] * jacobian[1][0];
    const Batch s = Batch(1.0) / det;
    inverse[0][0] = jacobian[1][1] * s;
    inverse[0][1] = -(jacobian[0][1] * s);
    inverse[1][0] = -(jacobian[1][0] * s);
    inverse[1][1] = jacobian[0][0] * s;
  } else {
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const int a = (i + 1) % 3, b = (i + 2) % 3, k = (j + 1) % 3, l = (j + 2) % 3;
        inverse[j][i] = jacobian[a][k] * jacobian[b][l] - jacobian[a][l] * jacobian[b][k];
      }
    det = jacobian[0][0] * inverse[0][0] + jacobian[1][0] * inverse[0][1] + jacobian[2][0] * inverse[0][2];
    const Batch s = Batch(1.0) / det;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) inverse[i][j] *= s;
  }
  for (int a = 0; a < Cell::nodes; ++a)
    for (int i = 0; i < d; ++i) {
      Batch s = dN[a][0] * inverse[0][i];
      for (int j = 1; j < d; ++j) s += dN[a][j] * inverse[j][i];
      out.dN[a][i] = s;
    }
  out.weight = w * det;
  if constexpr (frame == Frame::axisymmetric) {
    Batch R = N[0] * X[0];
    for (int a = 1; a < Cell::nodes; ++a) R += N[a] * X[a * d];
    const Batch s = Batch(1.0) / R;
    for (int a = 0; a < Cell::nodes; ++a) out.ring[a] = N[a] * s;
    out.weight *= 2 * std::numbers::pi * R;
  }
}

template <class Cell, Frame frame>
inline void point_geometry(const Batch* X, int q, PointGeometry<Cell, frame>& out) {
  const auto& t = shape_table<Cell>;
  point_geometry<Cell, frame>(X, t.N[q], t.dN[q], t.weight[q], out);
}

template <class Cell, Frame frame>
inline void centroid_geometry(const Batch* X, PointGeometry<Cell, frame>& out) {
  const auto& t = shape_table<Cell>;
  point_geometry<Cell, frame>(X, t.N0, t.dN0, 1, out);
}

/// Value of a nodal scalar at point q.
template <class Cell> inline Batch interpolate(const Batch* nodal, int q) {
  const auto& N = shape_table<Cell>.N[q];
  Batch s = N[0] * nodal[0];
  for (int a = 1; a < Cell::nodes; ++a) s += N[a] * nodal[a];
  return s;
}

/// Component i of a nodal vector at point q.
template <class Cell> inline Batch interpolate(const Batch* nodal, int q, int i) {
  const auto& N = shape_table<Cell>.N[q];
  Batch s = N[0] * nodal[i];
  for (int a = 1; a < Cell::nodes; ++a) s += N[a] * nodal[a * Cell::dim + i];
  return s;
}

template <class Cell, Frame frame>
inline Vector<Batch, Cell::dim> gradient_of_scalar(const PointGeometry<Cell, frame>& g, const Batch* nodal) {
  Vector<Batch, Cell::dim> r;
  for (int i = 0; i < Cell::dim; ++i) {
    r[i] = g.dN[0][i] * nodal[0];
    for (int a = 1; a < Cell::nodes; ++a) r[i] += g.dN[a][i] * nodal[a];
  }
  return r;
}

/// Grad u, with u_R/R in the 33 component of the axisymmetric frame.
template <class Cell, Frame frame>
inline Tensor<Batch, Cell::dim> gradient_of_vector(const PointGeometry<Cell, frame>& g, const Batch* nodal) {
  constexpr int d = Cell::dim;
  Tensor<Batch, d> H;
  for (int i = 0; i < d; ++i)
    for (int j = 0; j < d; ++j) {
      Batch s = nodal[i] * g.dN[0][j];
      for (int a = 1; a < Cell::nodes; ++a) s += nodal[a * d + i] * g.dN[a][j];
      H[d * i + j] = s;
    }
  if constexpr (d == 2) {
    H[4] = Batch(0.0);
    if constexpr (frame == Frame::axisymmetric)
      for (int a = 0; a < Cell::nodes; ++a) H[4] += nodal[a * d] * g.ring[a];
  }
  return H;
}

} // namespace impact
