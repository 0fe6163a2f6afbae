#pragma once
#include <impact/kernel/frame.hpp>
#include <impact/kernel/nodal_values.hpp>
#include <impact/math/tensor.hpp>
#include <numbers>

/// How the reference cell lies in the reference configuration at one point, and gradients of nodal fields by
/// this map.
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
