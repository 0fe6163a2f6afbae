#pragma once
#include <impact/kernel/bulk_viscosity.hpp>
#include <impact/kernel/extra_stress.hpp>
#include <impact/kernel/motion_terms.hpp>
#include <impact/kernel/plane_stress.hpp>
#include <impact/kernel/spatial_map.hpp>

/// The law at the solution of a step, on one batch of cells: flow, what drives damage and heat, what was
/// lost; in explicit steps the internal force with it.
namespace impact {

/// What flow dissipates, g_p k_d dalpha.
template <int d>
inline Batch flow_dissipation(const PointLaw& law, const PointEvaluation<d>& e, const Batch& alpha,
                              const Batch& dalpha) {
  return e.g.p.g * (dissipative_stress(law.parameters, e.flow.at, alpha, dalpha) * dalpha);
}

/// That and b_d |C - C_n|^2 / dt of the step.
template <class Cell, Frame frame>
inline Batch dissipation_at(const PointLaw& law, const MotionInput& in, const CellState<Cell, frame>& s,
                            const PointEvaluation<Cell::dim>& e, int q, Batch lost) {
  if (law.viscous() && in.u_n) {
    const auto dC = step_of_C<Cell, frame>(s, e.k.F, in.u_n, q);
    lost += (1 / in.dt) * (viscosity(law.parameters, e.g) * dot(dC, dC));
  }
  return lost;
}

/// What the flow of a step dissipates and what elastic energy it releases, at one point.
struct FlowBook {
  Batch lost, released;
};

template <int d>
inline FlowBook flow_book(const PointLaw& law, const PointEvaluation<d>& e, const Batch& alpha,
                          const Batch& dalpha, const Batch& z_trial, const Batch& z) {
  const Batch released = isochoric_energy(law.parameters, trace_excess(e.flow.trial, z_trial) - z);
  return {flow_dissipation(law, e, alpha, dalpha), e.g.e1.g * select(e.flow.plastic, released, Batch(0.0))};
}
/// Where the work of the degraded stress is `power` k dalpha with another degradation than g_p, what the
/// store does not take of it is lost.
template <int d>
inline FlowBook flow_book(const PointLaw& law, const SplitEvaluation<d>& e, const Batch& alpha,
                          const Batch& dalpha, const Batch&, const Batch&) {
  const SplitFlow work = split_work(law, e.state, e.flow);
  const Batch k = flow_stress(law.parameters, e.flow).k;
  return {flow_dissipation(law, e, alpha, dalpha) + (work.power - e.g.p.g) * (k * dalpha), work.released};
}

/// Adds it to the sums, with the weight of the point, and returns what is lost.
inline Batch book(const FlowBook& flow, const Batch& w, StepSums& sums) {
  sums.plastic_dissipation += w * flow.lost;
  sums.least_dissipation = min(flow.lost, sums.least_dissipation);
  sums.plastic_work += w * flow.released;
  return flow.lost;
}

/// The internal force of a step whose forces and flow are found together.
template <class Cell, Frame frame> struct StepForces {
  Fluxes<Cell, frame> fluxes;
  BulkRate bulk{};
  bool pressed = false, extra = false;

  void start(const PointLaw& law, const MotionInput& in, const CellState<Cell, frame>& s) {
    pressed = in.has_bulk_viscosity() && in.u_n;
    extra = (law.crack_stress() && in.phi) || (law.viscous() && in.u_n);
    if (pressed) bulk = bulk_rate(law, in, s);
  }
  void add(const PointLaw& law, const MotionInput& in, const CellState<Cell, frame>& s,
           const PointEvaluation<Cell::dim>& e, int q) {
    CurrentMap<Cell, frame> map;
    current_map(s.map[q], e.k.inverse_F, map);
    Symmetric<Batch, Cell::dim> tau = e.tau;
    if (extra) {
      Vector<Batch, Cell::dim> h;
      tau = tau + extra_stress<Cell, frame>(law, in, s, e, q, h);
    }
    press(s.H[q], tau);
    fluxes.set(q, map, s.map[q].weight, tau);
  }
  /// Adds the pressure of bulk viscosity.
  void press(const Tensor<Batch, Cell::dim>& H, Symmetric<Batch, Cell::dim>& tau) const {
    if (!pressed) return;
    const Batch minus_q = bulk_stress<frame>(bulk, H);
    for (int i = 0; i < 3; ++i) tau[i] += minus_q;
  }
  /// Pressure, as a stress, of bulk viscosity, which goes by the volume of the cell.
  Batch pressure() const { return pressed ? bulk.viscosity * bulk.rate / bulk.J : Batch(0.0); }
  /// What bulk viscosity loses in a step, per volume.
  Batch lost(double dt) const { return dt * (bulk.viscosity * (bulk.rate * bulk.rate)); }
  /// r += the force; the lanes in which it is not finite.
  int finish(Batch* r) const {
    fluxes.add_forces(r);
    Batch finite = Batch(0.0);
    for (int i = 0; i < dofs<Cell>; ++i) finite += r[i] - r[i];
    return bits(~is_finite(finite));
  }
};

/// What drives damage at one point, and what a law that softens has stored.
template <class Cell, class Point>
Drive driving_energies(const PointLaw& law, const MotionInput& in, const Point& e, const Batch& alpha_n,
                       const Batch& alpha, const Batch& z, int q) {
  PointEnergies<Batch> energy = point_energies<Cell>(law, z, e.Je_minus_1, alpha, in.theta, q);
  if constexpr (requires { e.of.plus; }) energy = {e.of.plus, e.of.minus, energy.plastic};
  if (law.softens())
    energy.plastic =
        law.plastic_energy(e.flow, alpha_n, in.drive ? drive_at(in.drive, q).plastic : Batch(0.0));
  return {energy.plus, energy.minus, law.plastic_drive(energy.plastic)};
}

/// With `heats` also what the heat balance asks for, with `forces` the internal force. Forces is a constant
/// where a run without them is to pay nothing and to keep its last digits.
template <class Cell, Frame frame, bool heats, bool principal, class Forces>
inline CellStatus advance(const PointLaw& law, const MotionInput& in, Batch* trial_history, Batch* drive,
                          StepSums& sums, const HeatFeed& heat, Forces forces, Batch* r) {
  constexpr int d = Cell::dim;
  CellStatus status{0, Batch(1e300)};
  CellStateOf<Cell, frame, principal> s;
  prepare<Cell, frame>(law, in.X, in.u, in.phi, in.theta, s, in.history, in.unilateral,
                       {in.patch, in.patch_pressure, in.warming});
  status.bad |= share_unknowns<Cell, frame, principal>(law, in, s);
  StepForces<Cell, frame> force;
  if (forces) force.start(law, in, s);
  for (int q = 0; q < Cell::points; ++q) {
    const auto e = evaluate_point<Cell, frame, principal>(law, in, s, q);
    note<Cell, frame>(status, law, s, e, q);
    if (forces) force.add(law, in, s, e, q);
    const PointHistory<Batch, d> old = read_history<frame>(law, in.history, q);
    const Batch z_trial = e.flow.y - Batch(1.0);
    const Batch z = trace_excess(e.flow.dev_b, z_trial), w = s.map[q].weight;
    const PointHistory<Batch, d> now = law.updated(e.k, old, e.flow, z);
    if (drive) {
      drive_at(drive, q) = driving_energies<Cell>(law, in, e, old.alpha, now.alpha, z, q);
      const Drive& kept = drive_at(drive, q);
      status.bad |= bits(~is_finite(kept.plus + kept.minus + kept.plastic));
    }
    status.bad |= bits(~is_finite(e.Je_minus_1 + z));
    if (trial_history) {
      HistoryOf<frame>& kept = history_at<frame>(trial_history, q);
      kept.A = now.A;
      kept.alpha = now.alpha;
      if constexpr (frame == Frame::plane_stress) kept.stretch = s.H[q][4];
    }
    Batch lost = Batch(0.0);
    if (law.flows()) lost = book(flow_book(law, e, now.alpha, now.alpha - old.alpha, z_trial, z), w, sums);
    if constexpr (heats) {
      if (heat.stress) {
        Vector<Batch, d> h;
        Symmetric<Batch, d> tau = e.tau + extra_stress<Cell, frame>(law, in, s, e, q, h);
        if (forces) force.press(s.H[q], tau);
        const Tensor<Batch, d> P = first_piola(tau, e.k.inverse_F);
        Batch* const stress = &heat.stress[q * stress_size(frame)];
        for (int i = 0; i < gradient_size(frame); ++i) stress[i] = P[i];
        // Bulk viscosity knows the volume of a cell, not of its patch: its work stays where it is done.
        stress[gradient_size(frame)] = forces && !is_linear_simplex<Cell> ? e.p + force.pressure() : e.p;
      }
      if (heat.dissipation) heat.dissipation[q] = dissipation_at<Cell, frame>(law, in, s, e, q, lost);
      if (forces && heat.dissipation) heat.dissipation[q] += force.lost(in.dt);
    }
    if (forces) sums.viscous_dissipation += w * force.lost(in.dt);
    if (law.viscous() && in.u_n) {
      const auto dC = step_of_C<Cell, frame>(s, e.k.F, in.u_n, q);
      const Batch viscous = (1 / in.dt) * (viscosity(law.parameters, e.g) * dot(dC, dC));
      sums.viscous_dissipation += w * viscous;
      sums.least_dissipation = min(viscous, sums.least_dissipation);
    }
  }
  if (forces) status.bad |= force.finish(r);
  return status;
}

template <class Cell, Frame frame, bool heats, Terms terms, class Forces>
[[gnu::flatten, gnu::noinline]] CellStatus advance_with(const PointLaw& law, const MotionInput& in,
                                                        Batch* trial_history, Batch* drive, StepSums& sums,
                                                        const HeatFeed& heat, Forces forces, Batch* r) {
  const LastDigits kept;
  return advance<Cell, frame, heats, terms == Terms::principal>(restricted<terms>(law), restricted(in, terms),
                                                                trial_history, drive, sums, heat, forces, r);
}

/// A short law in a linear cell has a body of code for each of what is asked, others do all with one.
template <class Cell, Frame frame, class Forces>
CellStatus advance_as_asked(const PointLaw& law, const MotionInput& in, Batch* trial_history, Batch* drive,
                            StepSums& sums, const HeatFeed& heat, Forces forces, Batch* r) {
  const bool heats = heat.dissipation || heat.stress;
  return with_terms<Cell, frame>(terms_of(law, in), [&](auto terms) {
    if constexpr (is_long(terms) || is_second_order<Cell>)
      return advance_with<Cell, frame, true, terms, bool>(law, in, trial_history, drive, sums, heat, forces,
                                                          r);
    else if (heats)
      return advance_with<Cell, frame, true, Terms::plain>(law, in, trial_history, drive, sums, heat, forces,
                                                           r);
    else
      return advance_with<Cell, frame, false, terms>(law, in, trial_history, drive, sums, heat, forces, r);
  });
}

template <class Cell, Frame frame>
CellStatus motion_advance(const PointLaw& law, const MotionInput& in, Batch* trial_history, Batch* drive,
                          StepSums& sums, const HeatFeed& heat) {
  return advance_as_asked<Cell, frame>(law, in, trial_history, drive, sums, heat, std::false_type{}, nullptr);
}

template <class Cell, Frame frame>
CellStatus motion_step(const PointLaw& law, const MotionInput& in, Batch* trial_history, Batch* drive,
                       StepSums& sums, const HeatFeed& heat, Batch* r) {
  return advance_as_asked<Cell, frame>(law, in, trial_history, drive, sums, heat, std::true_type{}, r);
}

} // namespace impact
