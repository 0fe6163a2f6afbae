#pragma once
#include <impact/element/cells.hpp>
#include <impact/kernel/frame.hpp>
#include <impact/math/batch.hpp>
#include <impact/math/tensor.hpp>

#include <numbers>

/// Reference gradients, weights and gradients of nodal fields of one batch of cells.
namespace impact {

/// Grad xi (inverse[k * dim + j] = dxi_k/dX_j) and dV_0 where dX_i/dxi_j = jacobian[i * dim + j].
template <int d> inline Batch invert_jacobian(const Batch* jacobian, Batch* inverse) {
  Batch det;
  if constexpr (d == 2) {
    det = jacobian[0] * jacobian[3] - jacobian[1] * jacobian[2];
    const Batch s = Batch(1.0) / det;
    inverse[0] = jacobian[3] * s;
    inverse[1] = -(jacobian[1] * s);
    inverse[2] = -(jacobian[2] * s);
    inverse[3] = jacobian[0] * s;
  } else {
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const int a = (i + 1) % 3, b = (i + 2) % 3, k = (j + 1) % 3, l = (j + 2) % 3;
        inverse[3 * j + i] =
            jacobian[3 * a + k] * jacobian[3 * b + l] - jacobian[3 * a + l] * jacobian[3 * b + k];
      }
    det = jacobian[0] * inverse[0] + jacobian[3] * inverse[1] + jacobian[6] * inverse[2];
    const Batch s = Batch(1.0) / det;
    for (int i = 0; i < 9; ++i) inverse[i] *= s;
  }
  return det;
}

/// How the reference cell lies in the reference configuration, at one point.
template <class Cell, Frame frame> struct PointMap {
  Batch inverse[Cell::dim * Cell::dim]; ///< dxi_k/dX_j
  Batch weight;                         ///< dV_0
  Batch inverse_R;                      ///< 1/R, set in the axisymmetric frame
};

/// N are the shape functions and w is the weight of the point.
template <class Cell, Frame frame>
inline void point_map(const Batch* X, const Batch* jacobian, const double (&N)[Cell::nodes], double w,
                      PointMap<Cell, frame>& out) {
  out.weight = w * invert_jacobian<Cell::dim>(jacobian, out.inverse);
  if constexpr (frame == Frame::axisymmetric) {
    const Batch R = sum<Cell::nodes>([&](int a) { return N[a] * X[a * Cell::dim]; });
    out.inverse_R = Batch(1.0) / R;
    out.weight *= 2 * std::numbers::pi * R;
  }
}

/// dv_i/dxi_k, [i * dim + k], where the reference derivatives of the shape functions are dN.
template <class Cell, int components>
inline void reference_gradient(const double (&dN)[Cell::nodes][Cell::dim], const Batch* nodal, Batch* slope) {
  for (int i = 0; i < components; ++i)
    for (int k = 0; k < Cell::dim; ++k)
      slope[i * Cell::dim + k] =
          sum<Cell::nodes>([&](int a) { return dN[a][k] * nodal[a * components + i]; });
}

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

template <class Cell, Frame frame>
inline void point_geometry(const Batch* X, int q, PointGeometry<Cell, frame>& out) {
  const auto& t = shape_table<Cell>;
  point_geometry<Cell, frame>(X, t.N[q], t.dN[q], t.weight[q], out);
}

/// Component i of a nodal field of `components` at point q.
template <class Cell, int components = 1> inline Batch interpolate(const Batch* nodal, int q, int i = 0) {
  const auto& N = shape_table<Cell>.N[q];
  return sum<Cell::nodes>([&](int a) { return N[a] * nodal[a * components + i]; });
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

/// Grad v from dv_i/dxi_k where the shape functions are N, with v_R/R in the 33 component of the axisymmetric
/// frame.
template <class Cell, Frame frame>
inline Tensor<Batch, Cell::dim> mapped_gradient(const PointMap<Cell, frame>& map, const Batch* slope,
                                                const double (&N)[Cell::nodes], const Batch* nodal) {
  constexpr int d = Cell::dim;
  Tensor<Batch, d> H;
  for (int i = 0; i < d; ++i)
    for (int j = 0; j < d; ++j)
      H[d * i + j] = sum<d>([&](int k) { return slope[i * d + k] * map.inverse[k * d + j]; });
  if constexpr (d == 2) H[4] = Batch(0.0);
  if constexpr (frame == Frame::axisymmetric) {
    for (int a = 0; a < Cell::nodes; ++a) H[4] += N[a] * nodal[a * d];
    H[4] *= map.inverse_R;
  }
  return H;
}

/// Grad of a nodal scalar at point q.
template <class Cell, Frame frame>
inline Vector<Batch, Cell::dim> gradient_of_scalar(const PointMap<Cell, frame>& map, const Batch* nodal,
                                                   int q) {
  constexpr int d = Cell::dim;
  Batch slope[d];
  reference_gradient<Cell, 1>(shape_table<Cell>.dN[q], nodal, slope);
  Vector<Batch, d> r;
  for (int j = 0; j < d; ++j) r[j] = sum<d>([&](int k) { return slope[k] * map.inverse[k * d + j]; });
  return r;
}

} // namespace impact
