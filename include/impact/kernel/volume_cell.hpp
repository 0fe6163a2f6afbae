#pragma once
#include <impact/kernel/motion_point.hpp>
#include <impact/kernel/spatial_map.hpp>

/// What cells give to the volume ratio and the pressure that a patch of them shares (theory.md, volumetric
/// locking).
namespace impact {

/// body(weight, J - 1, map, Grad u, q) at the points of the cell; at one for all of them where J is constant.
template <class Cell, Frame frame, class Body>
inline void for_each_volume(const Batch* X, const Batch* u, Body&& body) {
  constexpr int d = Cell::dim;
  constexpr bool constant = is_linear_simplex<Cell> && frame != Frame::axisymmetric;
  constexpr int points = constant ? 1 : Cell::points;
  const auto& t = shape_table<Cell>;
  for (int q = 0; q < points; ++q) {
    Batch jacobian[d * d], slope[d * d];
    PointMap<Cell, frame> map;
    reference_gradient<Cell, d>(t.dN[q], X, jacobian);
    reference_gradient<Cell, d>(t.dN[q], u, slope);
    point_map<Cell, frame>(X, jacobian, t.N[q], constant ? Cell::points * t.weight[q] : t.weight[q], map);
    const Tensor<Batch, d> H = mapped_gradient<Cell, frame>(map, slope, t.N[q], u);
    body(map.weight, detm1(H), map, H, q);
  }
}

template <class Cell, Frame frame>
void cell_volume(const Batch* X, const Batch* u, Batch& volume, Batch& growth) {
  volume = growth = Batch(0.0);
  for_each_volume<Cell, frame>(X, u, [&](const Batch& w, const Batch& J_minus_1, auto&&...) {
    volume += w;
    growth += w * J_minus_1;
  });
}

template <class Cell, Frame frame> void volume_slope(const Batch* X, const Batch* u, Batch* v) {
  const auto& t = shape_table<Cell>;
  for (int i = 0; i < dofs<Cell>; ++i) v[i] = Batch(0.0);
  for_each_volume<Cell, frame>(
      X, u,
      [&](const Batch& w, const Batch& J_minus_1, const auto& map, const Tensor<Batch, Cell::dim>& H, int q) {
        const Batch J = Batch(1.0) + J_minus_1, wJ = w * J;
        CurrentMap<Cell, frame> current;
        SpatialGradients<Cell, frame> G;
        current_map(map, inverse(plus_identity(H), J), current);
        spatial_gradients(current, t.N[q], t.dN[q], G);
        for (int a = 0; a < Cell::nodes; ++a)
          for (int i = 0; i < Cell::dim; ++i)
            v[a * Cell::dim + i] += wJ * volume_gradient<Cell, frame>(G, a, i);
      });
}

template <class Cell, Frame frame>
void cell_pressure(const PointLaw& law, const MotionInput& in, Batch& p, Batch& dp) {
  p = dp = Batch(0.0);
  for (int q = 0; q < Cell::points; ++q) {
    const auto& t = shape_table<Cell>;
    Batch jacobian[Cell::dim * Cell::dim];
    PointMap<Cell, frame> map;
    reference_gradient<Cell, Cell::dim>(t.dN[q], in.X, jacobian);
    point_map<Cell, frame>(in.X, jacobian, t.N[q], t.weight[q], map);
    const Volumetric<Batch> v =
        warmed(law.pressure(*in.patch, point_thermal_volume<Cell>(law, in.theta, q),
                            point_degradations<Cell, frame>(law, in.phi, q, in.history, in.unilateral)),
               in.warming, *in.patch, q);
    p += map.weight * v.p;
    dp += map.weight * v.dp;
  }
}

} // namespace impact
