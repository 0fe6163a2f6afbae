#pragma once
#include <algorithm>
#include <impact/kernel/fatigue.hpp>
#include <impact/kernel/plane_stress.hpp>
#include <impact/material/fatigue.hpp>

/// The growth of fatigue of fatigue.hpp on one batch of cells.
namespace impact {

/// S_c of the undamaged body at one point. The history is that of the displacement: nothing flows here.
template <class Cell, Frame frame>
Symmetric<Batch, Cell::dim> undamaged_stress(const PointLaw& law, const CellState<Cell, frame>& s,
                                             const Batch* theta, const Batch* history, int q) {
  constexpr int d = Cell::dim;
  const MaterialParameters& m = law.parameters;
  const Kinematics<Batch, d> k = kinematics(s.H[q]);
  Symmetric<Batch, d> e = left_strain(s.H[q]);
  if (law.flows()) e = e + push(k.F, read_history<frame>(law, history, q).A - identity<Batch, d>());
  Batch p = m.locking == Locking::mean ? s.mean_p : Batch(0.0), zeta = Batch(1.0);
  if (m.locking != Locking::mean) {
    const Batch J_minus_1 = m.locking == Locking::none ? k.J_minus_1 : s.volume_J;
    p = law.pressure(J_minus_1, point_thermal_volume<Cell>(law, theta, q),
                     degradations(m, Batch(0.0), Batch(0.0)))
            .p;
  }
  if (m.locking == Locking::fbar) zeta = k.J / (Batch(1.0) + s.volume_J);
  Symmetric<Batch, d> tau = (m.G * (zeta * k.J23)) * dev(e);
  for (int i = 0; i < 3; ++i) tau[i] += p * k.J;
  return push(k.inverse_F, tau);
}

template <class Cell, Frame frame>
[[gnu::flatten]] int fatigue_advance(const PointLaw& law, const FatigueInput& in, Batch* fatigue,
                                     FatigueSums& sums) {
  constexpr int d = Cell::dim;
  const MaterialParameters& m = law.parameters;
  CellState<Cell, frame> now, before;
  prepare<Cell, frame>(law, in.X, in.u, nullptr, in.theta, now);
  prepare<Cell, frame>(law, in.X, in.u_n, nullptr, in.theta_n, before);
  read_thickness<Cell, frame>(in.history, now);
  read_thickness<Cell, frame>(in.history_n, before);
  std::copy(before.start_33, before.start_33 + Cell::points, now.start_33);
  Batch finite = Batch(0.0);
  int bad = 0;
  for (int q = 0; q < Cell::points; ++q) {
    const Tensor<Batch, d> F = plus_identity(now.H[q]);
    bad |= bits(~(detm1(now.H[q]) > Batch(-1.0)));
    const auto S = undamaged_stress<Cell, frame>(law, now, in.theta, in.history, q);
    const auto S_n = undamaged_stress<Cell, frame>(law, before, in.theta_n, in.history_n, q);
    const auto dC = step_of_C<Cell, frame>(now, F, in.u_n, q);
    const Batch phi = interpolate<Cell>(in.phi, q);
    Batch work = 0.25 * dot(S + S_n, dC);
    if (law.viscous())
      work +=
          (1 / in.dt) *
          (viscosity(m, degradations(m, phi, point_alpha<Cell, frame>(law, in.history_n, q))) * dot(dC, dC));
    const Batch growth = fatigue_growth(m, phi, work), lost = fatigue_dissipation(m, phi, growth);
    fatigue[q] = in.fatigue_n[q] + growth;
    sums.dissipation += now.map[q].weight * lost;
    sums.least = min(lost, sums.least);
    finite += fatigue[q] - fatigue[q];
  }
  return bad | bits(~is_finite(finite));
}

} // namespace impact
