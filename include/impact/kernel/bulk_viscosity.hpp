#pragma once
#include <impact/kernel/motion_input.hpp>
#include <impact/kernel/motion_point.hpp>

/// Bulk viscosity of explicit steps (J. von Neumann, R. D. Richtmyer, J. Appl. Phys. 21 (1950) 232; R.
/// Landshoff, LA-1930 (1955)): a pressure that spreads shocks over a few cells and damps what rings behind
/// them, against compression alone,
///   q = rho l |D| (a^2 l |D| + b c)      D = dJ/dt / J < 0 of the cell, l its size, c its speed of sound
/// a = -bulk_viscosity_quadratic, b = -bulk_viscosity_linear.
namespace impact {

/// Of a cell: factor of -D in the Kirchhoff pressure J q, and D. Both 0 where the cell does not shrink.
struct BulkRate {
  Batch viscosity, rate;
};

template <class Cell, Frame frame>
inline BulkRate bulk_rate(const PointLaw& law, const MotionInput& in, const CellState<Cell, frame>& s) {
  constexpr int d = Cell::dim;
  const MaterialParameters& m = law.parameters;
  const auto& t = shape_table<Cell>;
  Batch now = Batch(0.0), before = Batch(0.0);
  for (int q = 0; q < Cell::points; ++q) {
    Batch slope[d * d];
    reference_gradient<Cell, d>(t.dN[q], in.u_n, slope);
    Tensor<Batch, d> H_n = mapped_gradient<Cell, frame>(s.map[q], slope, t.N[q], in.u_n);
    if constexpr (frame == Frame::plane_stress) H_n[4] = s.start_33[q];
    now += s.map[q].weight * detm1(s.H[q]);
    before += s.map[q].weight * detm1(H_n);
  }
  const Batch J = Batch(1.0) + now / s.volume;
  const Batch rate = min((now - before) / (in.dt * (s.volume * J)), Batch(0.0));
  Batch l = s.volume * J;
  if constexpr (frame == Frame::axisymmetric) { // per length of the ring
    Batch R = Batch(0.0);
    for (int a = 0; a < Cell::nodes; ++a) R += (1.0 / Cell::nodes) * in.X[a * d];
    l = l / (2 * std::numbers::pi * R);
  }
  l = d == 2 ? sqrt(l) : Batch(1.0) / inverse_cbrt(l);
  const double c = std::sqrt((m.K + 4 * m.G / 3) / m.rho);
  const double a2 = in.bulk_quadratic * in.bulk_quadratic;
  const Batch viscosity = (m.rho * l) * (in.bulk_linear * c - a2 * (l * rate));
  return {select(rate < Batch(0.0), viscosity, Batch(0.0)), rate};
}

} // namespace impact
