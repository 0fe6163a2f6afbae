#pragma once
#include <impact/kernel/plane_stress.hpp>
#include <impact/material/failure.hpp>

/// Growth of the failure measure (55d) on one batch of cells.
namespace impact {

/// Writes failure [point] from failure_n. `at.history` is that of the end of the step, so that nothing flows
/// here; the stress is the one without its viscous part.
template <class Cell, Frame frame>
int failure_advance(const PointLaw& law, const MotionInput& at, const Batch* history_n,
                    const Batch* failure_n, Batch* failure) {
  constexpr int d = Cell::dim;
  const MaterialParameters& m = law.parameters;
  MotionInput in = at;
  in.held = true;
  CellState<Cell, frame> s;
  prepare<Cell, frame>(law, in.X, in.u, in.phi, in.theta, s, in.history, 1, {in.patch, in.patch_pressure});
  read_thickness<Cell, frame>(in.history, s);
  if (law.principal()) share_split_pressure<Cell, frame>(law, in, s);
  Batch finite = Batch(0.0);
  for (int q = 0; q < Cell::points; ++q) {
    const PointEvaluation<d> e = evaluate_any<Cell, frame>(law, in, s, q);
    const Batch growth = history_at<frame>(in.history, q).alpha - history_at<frame>(history_n, q).alpha;
    const Symmetric<Batch, d> deviator = dev(e.tau);
    const Batch mises = sqrt(1.5 * dot(deviator, deviator)), mean = (1.0 / 3) * trace(e.tau);
    const auto flows = growth > Batch(0.0);
    const Batch triaxiality = mean / select(flows & (mises > Batch(0.0)), mises, Batch(1.0));
    const Batch theta = in.theta ? interpolate<Cell>(in.theta, q) : Batch(m.theta0);
    const Batch strain = failure_strain(m, triaxiality, Batch((1 / in.dt) * growth), theta);
    failure[q] = failure_n[q] + select(flows, growth / strain, Batch(0.0));
    finite += failure[q] - failure[q];
  }
  return bits(~is_finite(finite));
}

} // namespace impact
