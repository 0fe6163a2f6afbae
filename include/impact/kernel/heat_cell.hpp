#pragma once
#include <impact/kernel/heat_input.hpp>
#include <impact/kernel/plane_stress.hpp>
#include <impact/kernel/point_geometry.hpp>
#include <impact/kernel/scalar_cell.hpp>
#include <impact/material/crack.hpp>
#include <impact/material/equation_of_state.hpp>

/// The heat balance on one batch of cells.
namespace impact {

/// g_v of the volume ratio J_e.
inline Batch volume_degradation(const Degradations<Batch>& g, const Batch& Je_minus_1) {
  return select(Je_minus_1 >= Batch(0.0), g.e1.g, g.e2.g);
}

/// F^-1 of a body that does not move.
template <int d> Tensor<Batch, d> unit_tensor() {
  Tensor<Batch, d> zero;
  for (int i = 0; i < tensor_size(d); ++i) zero[i] = Batch(0.0);
  return plus_identity(zero);
}

/// kappa grad theta in the reference configuration: k g_theta J C^-1 Grad theta, or k g_theta Grad theta.
/// F^-1 is null where nothing moves.
template <int d>
Vector<Batch, d> conducted(const MaterialParameters& m, const Degradations<Batch>& g,
                           const Tensor<Batch, d>* inverse_F, const Batch& J, const Vector<Batch, d>& grad) {
  const Batch k = m.conductivity * conduction_degradation(m, g.e1.g);
  if (!inverse_F || m.conduction == Conduction::material) return k * grad;
  return (k * J) * raised_gradient(*inverse_F, grad);
}

/// The state of one batch at one end of the step.
template <class Cell, Frame frame> struct HeatState {
  CellState<Cell, frame> cell;
  bool moved;
  const Batch *phi, *theta, *history, *drive;

  HeatState(const PointLaw& law, const Batch* X, const Batch* u, const Batch* nodal_phi,
            const Batch* nodal_theta, const Batch* point_history, const Batch* point_drive,
            const Batch* patch)
      : moved(u != nullptr), phi(nodal_phi), theta(nodal_theta), history(point_history), drive(point_drive) {
    cell.volume_J = Batch(0.0);
    if (!moved) return;
    prepare<Cell, frame>(law, X, u, nullptr, nullptr, cell, nullptr, 1, {patch, nullptr});
    read_thickness<Cell, frame>(point_history, cell);
  }
  /// J - 1 that the volumetric stress sees.
  Batch volume(const PointLaw& law, int q) const {
    if (!moved) return Batch(0.0);
    return law.parameters.locking == Locking::none ? detm1(cell.H[q]) : cell.volume_J;
  }
  /// g_1 W + g_p H_s + psi_phi: the internal energy but for what hangs on the temperature.
  Batch stored(const PointLaw& law, const PointGeometry<Cell, frame>& X, int q,
               const Degradations<Batch>& g) const {
    constexpr int d = Cell::dim;
    const MaterialParameters& m = law.parameters;
    Batch sum = Batch(0.0);
    Tensor<Batch, d> inverse_F = unit_tensor<d>();
    if (moved) {
      const Kinematics<Batch, d> k = kinematics(cell.H[q]);
      const PointHistory<Batch, d> A = read_history<frame>(law, history, q);
      Symmetric<Batch, d> e = left_strain(cell.H[q]);
      if (law.flows()) e = e + push(k.F, A.A - identity<Batch, d>());
      const Batch start = k.J23 * (Batch(1.0) + (1.0 / 3) * trace(e)) - Batch(1.0);
      sum = g.e1.g * isochoric_energy(m, trace_excess(k.J23 * dev(e), start));
      if (law.flows())
        sum += ((1 - m.taylor_quinney) * g.p.g) *
               (law.softens() && drive ? drive_at(drive, q).plastic : plastic_potential(m, A.alpha));
      inverse_F = k.inverse_F;
    }
    if (m.damage == Damage::none || !phi) return sum;
    return sum +
           crack_energy(m, interpolate<Cell>(phi, q), inverse_F, gradient_of_scalar<Cell, frame>(X, phi));
  }
};

/// 1/2 (P + P_n) : (F - F_n).
template <class Cell, Frame frame>
Batch work_of_stress(const HeatInput& in, const Tensor<Batch, Cell::dim>& H,
                     const Tensor<Batch, Cell::dim>& H_n, int q) {
  constexpr int n = gradient_size(frame);
  Batch work = Batch(0.0);
  for (int i = 0; i < n; ++i)
    work += (0.5 * (in.stress[q * n + i] + in.stress_n[q * n + i])) * (H[i] - H_n[i]);
  return work;
}

/// What damage and fatigue of the step bring into the energy, with the flux of the crack energy, or
/// dissipate.
template <class Cell, Frame frame>
void add_damage(const PointLaw& law, const HeatInput& in, const PointGeometry<Cell, frame>& X,
                const Tensor<Batch, Cell::dim>& inverse_F, int q, Batch& local,
                Vector<Batch, Cell::dim>& flux) {
  const MaterialParameters& m = law.parameters;
  const Batch phi = interpolate<Cell>(in.phi, q), phi_n = interpolate<Cell>(in.phi_n, q);
  if (in.form == HeatForm::energy) {
    if (in.fatigue)
      local += fatigue_energy(m, phi, in.fatigue[q]) - fatigue_energy(m, phi_n, in.fatigue_n[q]);
    flux = (crack_flux(m) * (phi - phi_n)) *
           crack_direction(m, inverse_F, gradient_of_scalar<Cell, frame>(X, in.phi));
  } else {
    if (in.fatigue) local -= fatigue_dissipation(m, phi, in.fatigue[q] - in.fatigue_n[q]);
    if (in.drive && law.exchanges()) local -= plastic_exchange_at<Cell, frame>(law, in, q);
  }
}

template <class Cell, Frame frame, class Law>
[[gnu::flatten]] int heat_step_of(const Law& law, const HeatInput& in, Batch* points, Batch* r) {
  constexpr int d = Cell::dim;
  const MaterialParameters& m = law.parameters;
  const auto& N = shape_table<Cell>.N;
  const bool energy = in.form == HeatForm::energy, has_damage = m.damage != Damage::none && in.phi;
  const HeatState<Cell, frame> now(law, in.X, in.u, in.phi, in.theta, in.history, in.drive, in.patch);
  const HeatState<Cell, frame> before(law, in.X, in.u_n, in.phi_n, in.theta_n, in.history_n, in.drive_n,
                                      in.patch_n);
  int bad = 0;
  Batch sum = Batch(0.0);
  for (int q = 0; q < Cell::points; ++q) {
    const auto X = point_geometry<Cell, frame>(in.X, q);
    const Degradations<Batch> g = point_degradations<Cell, frame>(law, in.phi, q, in.history),
                              g_n = point_degradations<Cell, frame>(law, in.phi_n, q, in.history_n);
    const Batch theta_n = interpolate<Cell>(in.theta_n, q);
    const ElasticVolume<Batch> v_n = elastic_volume(law, before.volume(law, q), theta_n);
    const Batch g_vn = volume_degradation(g_n, v_n.Je_minus_1);
    const Batch entropy_n = thermoelastic_entropy(law, v_n, g_vn);
    heat_point_at(points, q) = {now.volume(law, q), entropy_n};

    Tensor<Batch, d> inverse_F = unit_tensor<d>(), inverse_F_n = inverse_F;
    Batch J = Batch(1.0), J_n = Batch(1.0);
    if (in.u) {
      J += detm1(now.cell.H[q]);
      J_n += detm1(before.cell.H[q]);
      inverse_F = inverse(plus_identity(now.cell.H[q]), J);
      inverse_F_n = inverse(plus_identity(before.cell.H[q]), J_n);
      bad |= bits(~(J > Batch(0.0)) | ~(J_n > Batch(0.0)));
    }

    Batch local = Batch(0.0);
    Vector<Batch, d> flux;
    for (int i = 0; i < d; ++i) flux[i] = Batch(0.0);
    if (energy)
      local = now.stored(law, X, q, g) - before.stored(law, X, q, g_n) -
              (volume_energy(law, v_n, g_vn) + theta_n * entropy_n);
    else if (in.dissipation)
      local -= in.dissipation[q];
    if (has_damage) add_damage<Cell, frame>(law, in, X, inverse_F, q, local, flux);
    if (energy && in.u && in.stress)
      local -= work_of_stress<Cell, frame>(in, now.cell.H[q], before.cell.H[q], q);
    if (in.theta_h < 1 && m.conductivity != 0) {
      const auto k = conducted<d>(m, g_n, in.u ? &inverse_F_n : nullptr, J_n,
                                  gradient_of_scalar<Cell, frame>(X, in.theta_n));
      for (int i = 0; i < d; ++i) flux[i] += ((1 - in.theta_h) * in.dt) * k[i];
    }
    sum += local + flux[0];
    local *= X.weight;
    for (int a = 0; a < Cell::nodes; ++a) r[a] += N[q][a] * local + X.weight * dot(X.dN[a], flux);
  }
  return bad | bits(~is_finite(sum));
}

template <class Cell, Frame frame>
int heat_step(const PointLaw& law, const HeatInput& in, Batch* points, Batch* r) {
  return with_state<frame>(law, [&](const auto& l) { return heat_step_of<Cell, frame>(l, in, points, r); });
}

template <class Cell, Frame frame, bool tangent, class Law>
[[gnu::flatten]] int heat_balance(const Law& law, const HeatInput& in, const Batch* points, Batch* r_out,
                                  Batch* K_out) {
  constexpr int d = Cell::dim, n = Cell::nodes;
  const MaterialParameters& m = law.parameters;
  const auto& N = shape_table<Cell>.N;
  const bool energy = in.form == HeatForm::energy;
  ScalarCell<Cell, tangent> cell;
  int bad = 0;
  for (int q = 0; q < Cell::points; ++q) {
    const auto X = point_geometry<Cell, frame>(in.X, q);
    const Degradations<Batch> g = point_degradations<Cell, frame>(law, in.phi, q, in.history);
    const Batch theta = interpolate<Cell>(in.theta, q), theta_n = interpolate<Cell>(in.theta_n, q);
    bad |= bits(~(theta > Batch(0.0)));
    const ElasticVolume<Batch> v = elastic_volume(law, heat_point_at(points, q).volume, theta);
    const Batch g_v = volume_degradation(g, v.Je_minus_1);
    const Batch s = thermoelastic_entropy(law, v, g_v), capacity = heat_capacity(law, v, g_v, theta);
    Batch local, slope;
    if (energy) {
      local = m.c_v * (theta - theta_n) + theta * s + volume_energy(law, v, g_v);
      slope = capacity;
    } else {
      const Batch mean = in.theta_h * theta + (1 - in.theta_h) * theta_n;
      const Batch change = m.c_v * log_ratio(theta, theta_n) + (s - heat_point_at(points, q).entropy_n);
      local = mean * change;
      slope = in.theta_h * change + mean * (capacity / theta);
    }
    local *= X.weight;
    for (int a = 0; a < n; ++a) cell.r[a] += N[q][a] * local;
    if constexpr (tangent) {
      slope *= X.weight;
      for (int a = 0; a < n; ++a)
        for (int b = a; b < n; ++b) cell.K[a * n + b] += (N[q][a] * N[q][b]) * slope;
    }
    if (m.conductivity == 0) continue;

    Tensor<Batch, d> inverse_F = unit_tensor<d>();
    Batch J = Batch(1.0);
    const bool moved = in.u && m.conduction == Conduction::spatial;
    if (moved) {
      Tensor<Batch, d> H = gradient_of_vector<Cell, frame>(X, in.u);
      if constexpr (frame == Frame::plane_stress) H[4] = history_at<frame>(in.history, q).stretch;
      J += detm1(H);
      inverse_F = inverse(plus_identity(H), J);
    }
    const Batch w = (in.theta_h * in.dt) * X.weight;
    const auto flux =
        conducted<d>(m, g, moved ? &inverse_F : nullptr, J, gradient_of_scalar<Cell, frame>(X, in.theta));
    for (int a = 0; a < n; ++a) cell.r[a] += w * dot(X.dN[a], flux);
    if constexpr (tangent)
      for (int b = 0; b < n; ++b) {
        const auto column = conducted<d>(m, g, moved ? &inverse_F : nullptr, J, X.dN[b]);
        for (int a = 0; a <= b; ++a) cell.K[a * n + b] += w * dot(X.dN[a], column);
      }
  }
  return bad | cell.add_to(r_out, K_out);
}

template <class Cell, Frame frame>
int heat_residual(const PointLaw& law, const HeatInput& in, const Batch* points, Batch* r) {
  return with_state<frame>(
      law, [&](const auto& l) { return heat_balance<Cell, frame, false>(l, in, points, r, nullptr); });
}

template <class Cell, Frame frame>
int heat_tangent(const PointLaw& law, const HeatInput& in, const Batch* points, Batch* r, Batch* K) {
  return with_state<frame>(
      law, [&](const auto& l) { return heat_balance<Cell, frame, true>(l, in, points, r, K); });
}

template <class Cell, Frame frame>
void heat_source(const Batch* X, const Batch* source, Batch* r, Batch& sum) {
  for (int q = 0; q < Cell::points; ++q) {
    const auto g = point_geometry<Cell, frame>(X, q);
    const Batch heat = g.weight * source[q];
    for (int a = 0; a < Cell::nodes; ++a) r[a] += shape_table<Cell>.N[q][a] * heat;
    sum += heat;
  }
}

} // namespace impact
