#pragma once
#include <impact/kernel/heat_input.hpp>
#include <impact/kernel/heat_work.hpp>
#include <impact/kernel/lumped_mass.hpp>
#include <impact/kernel/plane_stress.hpp>
#include <impact/kernel/point_geometry.hpp>
#include <impact/kernel/scalar_cell.hpp>
#include <impact/material/crack.hpp>
#include <type_traits>

/// The heat balance on one batch of cells.
namespace impact {

/// g_v of the volume ratio J_e.
inline Batch volume_degradation(const Degradations<Batch>& g, const Batch& Je_minus_1) {
  return select(Je_minus_1 >= Batch(0.0), g.e1.g, g.e2.g);
}

/// Grad u and F^-1 of a body that does not move.
template <int d> Tensor<Batch, d> zero_tensor() {
  Tensor<Batch, d> zero;
  for (int i = 0; i < tensor_size(d); ++i) zero[i] = Batch(0.0);
  return zero;
}
template <int d> Tensor<Batch, d> unit_tensor() { return plus_identity(zero_tensor<d>()); }

/// Grad u at the end of the step, with that across a sheet.
template <class Cell, Frame frame>
Tensor<Batch, Cell::dim> moved_gradient(const HeatInput& in, const PointGeometry<Cell, frame>& X, int q) {
  if (!in.u) return zero_tensor<Cell::dim>();
  Tensor<Batch, Cell::dim> H = gradient_of_vector<Cell, frame>(X, in.u);
  if constexpr (frame == Frame::plane_stress) H[4] = history_at<frame>(in.history, q).stretch;
  return H;
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

/// What of the free energy hangs on the temperature at fixed strain: its energy, its entropy and theta
/// ds/dtheta with c_V.
struct ThermalPart {
  Batch energy, entropy, capacity;
};

/// theta beta^2/c_eff and beta/c_eff, beta = ds/dJ at fixed shape.
struct WarmingSlopes {
  Batch per_volume, per_heat;
};
inline WarmingSlopes warming_slopes(const Batch& theta, const Batch& beta, const Batch& capacity) {
  return {theta * (beta * beta) / capacity, beta / capacity};
}
/// Of a split by principal stretches, which sees J and theta in J/J_theta alone.
inline WarmingSlopes warming_slopes(const PointLaw& law, const ThermalPart& at, const Batch& J,
                                    const Batch& theta) {
  const MaterialParameters& m = law.parameters;
  const Batch beta = (Batch(m.c_v) - at.capacity) / ((3 * m.alpha_t) * (theta * J));
  return warming_slopes(theta, beta, at.capacity);
}
inline WarmingSlopes warming_slopes(const PointLaw& law, const Batch& J_minus_1, const Degradations<Batch>& g,
                                    const Batch& theta) {
  const ElasticVolume<Batch> v = elastic_volume(law, J_minus_1, theta);
  const Batch g_v = volume_degradation(g, v.Je_minus_1);
  return warming_slopes(theta, entropy_slope(law, v, g_v), heat_capacity(law, v, g_v, theta));
}

/// The energy is found where it is wanted.
inline ThermalPart thermal_part(const PointLaw& law, const Batch& J_minus_1, const Degradations<Batch>& g,
                                const Batch& theta, bool energy) {
  const ElasticVolume<Batch> v = elastic_volume(law, J_minus_1, theta);
  const Batch g_v = volume_degradation(g, v.Je_minus_1);
  return {energy ? volume_energy(law, v, g_v) : Batch(0.0), thermoelastic_entropy(law, v, g_v),
          heat_capacity(law, v, g_v, theta)};
}
/// Of a split by principal stretches, in a body with the gradient H.
template <Frame frame, int d>
[[gnu::noinline]] ThermalPart thermal_part(const PointLaw& law, const Tensor<Batch, d>& H,
                                           const Batch& J_minus_1, const Degradations<Batch>& g,
                                           const Batch& theta, const Batch* history, int q) {
  const Batch J_th = law.parameters.alpha_t == 0 ? Batch(1.0) : thermal_volume(law, theta);
  const SplitHeat at =
      split_heat(law, split_state<frame>(law, H, J_minus_1, J_th, g, history, q, {Batch(1.0), 0, true}));
  return {at.elastic, at.entropy, law.parameters.c_v + theta * at.entropy_slope};
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
    cell.volume_J.clear();
    if (!moved) return;
    prepare<Cell, frame>(law, X, u, nullptr, nullptr, cell, nullptr, 1, {patch, nullptr});
    read_thickness<Cell, frame>(point_history, cell);
  }
  /// J - 1 that the volumetric stress sees.
  Batch volume(const PointLaw& law, int q) const {
    if (!moved) return Batch(0.0);
    return law.parameters.locking == Locking::none ? detm1(cell.H[q]) : cell.shared_volume(q);
  }
  Tensor<Batch, Cell::dim> gradient(int q) const { return moved ? cell.H[q] : zero_tensor<Cell::dim>(); }
  ThermalPart thermal(const PointLaw& law, int q, const Degradations<Batch>& g, const Batch& at) const {
    return thermal_part<frame>(law, gradient(q), volume(law, q), g, at, history, q);
  }
  /// g_1 W + g_p H_s + psi_phi: the internal energy but for what hangs on the temperature, as all that is
  /// elastic does under a split by principal stretches.
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
      if (!law.principal()) sum = g.e1.g * isochoric_energy(m, trace_excess(k.J23 * dev(e), start));
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

template <class Cell, Frame frame>
[[gnu::flatten]] int heat_step(const PointLaw& law, const HeatInput& in, Batch* points, Batch* r) {
  constexpr int d = Cell::dim;
  const MaterialParameters& m = law.parameters;
  const auto& N = shape_table<Cell>.N;
  const bool energy = in.form == HeatForm::energy, has_damage = m.damage != Damage::none && in.phi;
  const HeatState<Cell, frame> now(law, in.X, in.u, in.phi, in.theta, in.history, in.drive, in.patch);
  const HeatState<Cell, frame> before(law, in.X, in.u_n, in.phi_n, in.theta_n, in.history_n, in.drive_n,
                                      in.patch_n);
  int bad = 0;
  Batch sum = Batch(0.0), unshared[Cell::points] = {};
  const bool works = energy && in.u && in.stress;
  if (works && m.locking != Locking::none) unshared_work(in, now.cell, before.cell, unshared);
  for (int q = 0; q < Cell::points; ++q) {
    const auto X = point_geometry<Cell, frame>(in.X, q);
    const Degradations<Batch> g = point_degradations<Cell, frame>(law, in.phi, q, in.history),
                              g_n = point_degradations<Cell, frame>(law, in.phi_n, q, in.history_n);
    const Batch theta_n = interpolate<Cell>(in.theta_n, q);
    const ThermalPart thermal_n = law.principal()
                                      ? before.thermal(law, q, g_n, theta_n)
                                      : thermal_part(law, before.volume(law, q), g_n, theta_n, energy);
    const Batch theta = interpolate<Cell>(in.theta, q), volume = now.volume(law, q);
    const WarmingSlopes warms =
        m.alpha_t == 0    ? WarmingSlopes{Batch(0.0), Batch(0.0)}
        : law.principal() ? warming_slopes(law, now.thermal(law, q, g, theta), Batch(1.0) + volume, theta)
                          : warming_slopes(law, volume, g, theta);

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
              (thermal_n.energy + theta_n * thermal_n.entropy);
    else if (in.dissipation)
      local -= in.dissipation[q];
    if (has_damage) add_damage<Cell, frame>(law, in, X, inverse_F, q, local, flux);
    if (works) local += unshared[q] - work_of_stress<Cell, frame>(in, now.cell.H[q], before.cell.H[q], q);
    if (in.theta_h < 1 && m.conductivity != 0) {
      const auto k = conducted<d>(m, g_n, in.u ? &inverse_F_n : nullptr, J_n,
                                  gradient_of_scalar<Cell, frame>(X, in.theta_n));
      for (int i = 0; i < d; ++i) flux[i] += ((1 - in.theta_h) * in.dt) * k[i];
    }
    sum += local + flux[0];
    heat_point_at(points, q) = {volume, thermal_n.entropy, warms.per_volume, warms.per_heat,
                                local,  Batch(0.0)};
    local *= X.weight;
    for (int a = 0; a < Cell::nodes; ++a) r[a] += N[q][a] * local + X.weight * dot(X.dN[a], flux);
  }
  return bad | bits(~is_finite(sum));
}

/// c_V (theta - theta_n), or [theta] c_V ln(theta/theta_n) of the entropy form, and its slope.
struct CapacityTerm {
  Batch value, slope;
};
inline CapacityTerm capacity_term(const HeatInput& in, const Batch& theta, const Batch& theta_n) {
  if (in.form == HeatForm::energy) return {theta - theta_n, Batch(1.0)};
  const Batch mean = in.theta_h * theta + (1 - in.theta_h) * theta_n, change = log_ratio(theta, theta_n);
  return {mean * change, in.theta_h * change + mean / theta};
}

/// The capacity as it stands at the nodes. Returns the lanes in which one of them is not warmer than 0 K.
template <class Cell, bool tangent>
int add_lumped_capacity(const HeatInput& in, const LumpedMass<Cell>& capacity,
                        ScalarCell<Cell, tangent>& cell) {
  int bad = 0;
  for (int a = 0; a < Cell::nodes; ++a) {
    bad |= bits(~(in.theta[a] > Batch(0.0)));
    const CapacityTerm term = capacity_term(in, in.theta[a], in.theta_n[a]);
    cell.r[a] += capacity.at[a] * term.value;
    if constexpr (tangent) cell.K[a * Cell::nodes + a] += capacity.at[a] * term.slope;
  }
  return bad;
}

/// The flux at a point at the end of the step.
template <class Cell, Frame frame, bool tangent>
void add_conduction(const MaterialParameters& m, const HeatInput& in, const PointGeometry<Cell, frame>& X,
                    const Degradations<Batch>& g, int q, ScalarCell<Cell, tangent>& cell) {
  constexpr int d = Cell::dim, n = Cell::nodes;
  Tensor<Batch, d> inverse_F = unit_tensor<d>();
  Batch J = Batch(1.0);
  const bool moved = in.u && m.conduction == Conduction::spatial;
  if (moved) {
    const Tensor<Batch, d> H = moved_gradient<Cell, frame>(in, X, q);
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

template <class Cell, Frame frame, bool tangent>
[[gnu::flatten]] int heat_balance(const PointLaw& law, const HeatInput& in,
                                  std::conditional_t<tangent, const Batch, Batch>* points, Batch* r_out,
                                  Batch* K_out) {
  constexpr int n = Cell::nodes;
  const MaterialParameters& m = law.parameters;
  const auto& N = shape_table<Cell>.N;
  const bool energy = in.form == HeatForm::energy;
  ScalarCell<Cell, tangent> cell;
  LumpedMass<Cell> capacity_at_nodes;
  int bad = 0;
  for (int q = 0; q < Cell::points; ++q) {
    const auto X = point_geometry<Cell, frame>(in.X, q);
    const Degradations<Batch> g = point_degradations<Cell, frame>(law, in.phi, q, in.history);
    const Batch theta = interpolate<Cell>(in.theta, q), theta_n = interpolate<Cell>(in.theta_n, q);
    bad |= bits(~(theta > Batch(0.0)));
    const Batch volume = heat_point_at(points, q).volume;
    const auto [stored, s, capacity] =
        law.principal()
            ? thermal_part<frame>(law, moved_gradient<Cell, frame>(in, X, q), volume, g, theta, in.history, q)
            : thermal_part(law, volume, g, theta, energy);
    Batch local, slope; // without c_V
    if (energy) {
      local = theta * s + stored;
      slope = capacity - Batch(m.c_v);
    } else {
      const Batch mean = in.theta_h * theta + (1 - in.theta_h) * theta_n;
      const Batch change = s - heat_point_at(points, q).entropy_n;
      local = mean * change;
      slope = in.theta_h * change + mean * ((capacity - Batch(m.c_v)) / theta);
    }
    const CapacityTerm term = capacity_term(in, theta, theta_n);
    if constexpr (!tangent)
      heat_point_at(points, q).excess = heat_point_at(points, q).source + local + m.c_v * term.value;
    if (in.lumped) {
      capacity_at_nodes.add(q, m.c_v, X.weight);
    } else {
      local += m.c_v * term.value;
      slope += m.c_v * term.slope;
    }
    local *= X.weight;
    for (int a = 0; a < n; ++a) cell.r[a] += N[q][a] * local;
    if constexpr (tangent) {
      slope *= X.weight;
      for (int a = 0; a < n; ++a)
        for (int b = a; b < n; ++b) cell.K[a * n + b] += (N[q][a] * N[q][b]) * slope;
    }
    if (m.conductivity != 0) add_conduction<Cell, frame>(m, in, X, g, q, cell);
  }
  if (in.lumped) {
    capacity_at_nodes.finish();
    bad |= add_lumped_capacity<Cell, tangent>(in, capacity_at_nodes, cell);
  }
  return bad | cell.add_to(r_out, K_out);
}

template <class Cell, Frame frame>
int heat_residual(const PointLaw& law, const HeatInput& in, Batch* points, Batch* r) {
  return heat_balance<Cell, frame, false>(law, in, points, r, nullptr);
}

template <class Cell, Frame frame>
int heat_tangent(const PointLaw& law, const HeatInput& in, const Batch* points, Batch* r, Batch* K) {
  return heat_balance<Cell, frame, true>(law, in, points, r, K);
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
