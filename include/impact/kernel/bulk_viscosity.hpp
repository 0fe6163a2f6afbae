#pragma once
#include <impact/kernel/motion_input.hpp>
#include <impact/kernel/motion_point.hpp>

/// Bulk viscosity of explicit steps (J. von Neumann, R. D. Richtmyer, J. Appl. Phys. 21 (1950) 232; R.
/// Landshoff, LA-1930 (1955)): a pressure that spreads shocks over a few cells and damps what rings behind
/// them, against compression alone,
///   q = rho l |D| (a^2 l |D| + b c)      D = dJ/dt / J < 0 of the cell, l its size, c its speed of sound
/// a = -bulk_viscosity_quadratic, b = -bulk_viscosity_linear.
namespace impact {

/// Of a cell: the factor of -D in its mean of the Kirchhoff pressure J q, how that changes with -D, both 0
/// where the cell does not shrink, D, and the mean of J. In a sheet J is that of the area: its thickness is
/// free, and no pressure works on it.
struct BulkRate {
  Batch viscosity, slope, rate, J;
};

/// J of the volume that bulk viscosity looks at, less 1.
template <Frame frame, int d> inline Batch bulk_detm1(Tensor<Batch, d> H) {
  if constexpr (frame == Frame::plane_stress) H[4] = Batch(0.0);
  return detm1(H);
}

/// -J q at a point: q is the same in all of the cell, so that its power is that of the cell's change of
/// volume.
template <Frame frame, int d> inline Batch bulk_stress(const BulkRate& bulk, const Tensor<Batch, d>& H) {
  return (bulk.viscosity * bulk.rate) * ((Batch(1.0) + bulk_detm1<frame>(H)) / bulk.J);
}

template <class Cell, Frame frame>
inline BulkRate bulk_rate(const PointLaw& law, const MotionInput& in, const CellState<Cell, frame>& s) {
  constexpr int d = Cell::dim;
  const MaterialParameters& m = law.parameters;
  const auto& t = shape_table<Cell>;
  Batch now = Batch(0.0), before = Batch(0.0);
  for (int q = 0; q < Cell::points; ++q) {
    Batch slope[d * d];
    reference_gradient<Cell, d>(t.dN[q], in.u_n, slope);
    now += s.map[q].weight * bulk_detm1<frame>(s.H[q]);
    before +=
        s.map[q].weight * bulk_detm1<frame>(mapped_gradient<Cell, frame>(s.map[q], slope, t.N[q], in.u_n));
  }
  const Batch J = Batch(1.0) + now / s.modes.volume;
  const Batch rate = min((now - before) / (in.dt * (s.modes.volume * J)), Batch(0.0));
  Batch l = s.modes.volume * J;
  if constexpr (frame == Frame::axisymmetric) { // per length of the ring
    Batch R = Batch(0.0);
    for (int a = 0; a < Cell::nodes; ++a) R += (1.0 / Cell::nodes) * in.X[a * d];
    l = l / (2 * std::numbers::pi * R);
  }
  l = d == 2 ? sqrt(l) : Batch(1.0) / inverse_cbrt(l);
  const double c = longitudinal_speed(m);
  const double a2 = in.bulk_quadratic * in.bulk_quadratic;
  const Batch linear = (m.rho * in.bulk_linear * c) * l, quadratic = (-m.rho * a2) * (l * l * rate);
  const auto shrinking = rate < Batch(0.0);
  return {select(shrinking, linear + quadratic, Batch(0.0)),
          select(shrinking, linear + 2.0 * quadratic, Batch(0.0)), rate, J};
}

} // namespace impact
