#pragma once
#include <algorithm>
#include <cmath>
#include <impact/kernel/damage_input.hpp>
#include <impact/kernel/plane_stress.hpp>
#include <impact/kernel/point_geometry.hpp>
#include <impact/kernel/scalar_cell.hpp>

/// The damage balance and the growth of fatigue on one batch of cells.
namespace impact {

/// Local source Y and its derivative with respect to phi.
struct DamageSource {
  Batch Y, dY;
};
inline DamageSource damage_source(const MaterialParameters& m, const Batch& phi, const Batch& alpha,
                                  const Drive& drive, const Batch& fatigue, bool convex) {
  const Degradations<Batch> g = degradations(m, phi, alpha);
  const Regularisation w = regularisation(m);
  const double crack = w.quadratic * (m.Gc / m.gamma), start = w.linear * (m.Gc / m.gamma);
  const Batch Y = g.e1.dg * drive.plus + g.e2.dg * drive.minus + g.p.dg * drive.plastic + crack * phi -
                  (1 / m.gamma) * fatigue + Batch(start);
  const Batch bend = g.e1.d2g * drive.plus + g.e2.d2g * drive.minus + g.p.d2g * drive.plastic;
  if (!convex) return {Y, bend + Batch(crack)};
  return {Y, max(bend + Batch(crack), 0.1 * (Batch(std::fabs(crack)) + abs(bend)))};
}

/// d(1/lambda)/dphi = zeta c (1 + delta - phi)^(-zeta-1), written with lambda.
inline Batch inverse_viscosity_slope(const MaterialParameters& m, const Batch& lambda, const Batch& phi) {
  return m.zeta / (lambda * (Batch(1.0 + m.delta) - phi));
}

template <class Cell, Frame frame, bool tangent>
[[gnu::flatten]] int damage(const PointLaw& law, const DamageInput& in, Batch* r_out, Batch* K_out) {
  constexpr int d = Cell::dim;
  const MaterialParameters& m = law.parameters;
  const auto& N = shape_table<Cell>.N;
  const double theta = in.theta_d, crack = crack_flux(m);
  const bool divided = in.form == DamageForm::divided;
  ScalarCell<Cell, tangent> cell;
  int bad = 0;
  for (int q = 0; q < Cell::points; ++q) {
    const auto X = point_geometry<Cell, frame>(in.X, q);
    const Batch phi = interpolate<Cell>(in.phi, q), phi_n = interpolate<Cell>(in.phi_n, q);
    const Vector<Batch, d> grad = gradient_of_scalar<Cell, frame>(X, in.phi);
    Vector<Batch, d> grad_n;
    if (divided || theta < 1) grad_n = gradient_of_scalar<Cell, frame>(X, in.phi_n);
    const Batch fatigue = in.fatigue ? in.fatigue[q] : Batch(0.0);
    const Batch alpha = point_alpha<Cell, frame>(law, in.history, q);
    const Batch lambda = damage_viscosity(m, phi_n);
    // Both forms are w * inertia * (phi - phi_n) + w * scale * [Y, h]: the divided one multiplied by
    // dt/lambda.
    const Batch inertia = divided ? Batch(1.0) : lambda * (1 / in.dt);
    const Batch scale = divided ? in.dt / lambda : Batch(1.0);

    const Tensor<Batch, d> H = gradient_of_vector<Cell, frame>(X, in.u);
    const Batch J = Batch(1.0) + detm1(H);
    bad |= bits(~(J > Batch(0.0)));
    const Tensor<Batch, d> inverse_F = inverse(plus_identity(H), J);
    const DamageSource now = damage_source(m, phi, alpha, drive_at(in.drive, q), fatigue, in.convex);
    Vector<Batch, d> flux = Batch(theta) * crack_direction(m, inverse_F, grad);
    Vector<Batch, d> frozen; // [C^-1]_theta Grad phi_n
    if (divided) frozen = Batch(theta) * crack_direction(m, inverse_F, grad_n);
    Batch local = theta * now.Y;
    if (theta < 1) {
      const Tensor<Batch, d> H_n = gradient_of_vector<Cell, frame>(X, in.u_n);
      const Tensor<Batch, d> inverse_F_n = inverse(plus_identity(H_n), Batch(1.0) + detm1(H_n));
      local += (1 - theta) * damage_source(m, phi_n, alpha, drive_at(in.drive_n, q), fatigue, false).Y;
      const Vector<Batch, d> flux_n = Batch(1 - theta) * crack_direction(m, inverse_F_n, grad_n);
      flux = flux + flux_n;
      if (divided) frozen = frozen + flux_n;
    }
    local = inertia * (phi - phi_n) + scale * local;
    if (divided) // w . Grad(1/lambda_n) term (112)
      local += (in.dt * crack) * (inverse_viscosity_slope(m, lambda, phi_n) * dot(grad_n, frozen));
    local *= X.weight;
    const Batch gradient_scale = crack * (scale * X.weight);
    for (int a = 0; a < Cell::nodes; ++a) cell.r[a] += N[q][a] * local + gradient_scale * dot(X.dN[a], flux);
    if constexpr (tangent) {
      const Batch reaction = X.weight * (inertia + theta * (scale * now.dY));
      for (int b = 0; b < Cell::nodes; ++b) {
        const Vector<Batch, d> w = crack_direction(m, inverse_F, X.dN[b]);
        for (int a = 0; a <= b; ++a)
          cell.K[a * Cell::nodes + b] +=
              (N[q][a] * N[q][b]) * reaction + theta * (gradient_scale * dot(X.dN[a], w));
      }
    }
  }
  return bad | cell.add_to(r_out, K_out);
}

template <class Cell, Frame frame> int damage_residual(const PointLaw& law, const DamageInput& in, Batch* r) {
  return damage<Cell, frame, false>(law, in, r, nullptr);
}

template <class Cell, Frame frame>
int damage_tangent(const PointLaw& law, const DamageInput& in, Batch* r, Batch* K) {
  return damage<Cell, frame, true>(law, in, r, K);
}

/// lambda(phi_n) (phi - phi_n)^2 / dt per volume.
template <class Cell>
void damage_dissipation(const PointLaw& law, const Batch* phi, const Batch* phi_n, double dt, Batch* points) {
  for (int q = 0; q < Cell::points; ++q) {
    Batch old = Batch(0.0), step = old;
    for (int a = 0; a < Cell::nodes; ++a) {
      old += shape_table<Cell>.N[q][a] * phi_n[a];
      step += shape_table<Cell>.N[q][a] * (phi[a] - phi_n[a]);
    }
    points[q] += (1 / dt) * (damage_viscosity(law.parameters, old) * (step * step));
  }
}

/// S_c of the undamaged body at one point. The history is that of the displacement: nothing flows here.
template <class Cell, Frame frame>
Symmetric<Batch, Cell::dim> undamaged_stress(const PointLaw& law, const CellState<Cell, frame>& s,
                                             const Batch* theta, const Batch* history, int q) {
  constexpr int d = Cell::dim;
  const MaterialParameters& m = law.parameters;
  const Kinematics<Batch, d> k = kinematics(s.H[q]);
  Symmetric<Batch, d> e = left_strain(s.H[q]);
  if (law.flows()) e = e + push(k.F, read_history<frame>(law, history, q).A - identity<Batch, d>());
  Batch p = m.locking == Locking::mean ? s.shared_pressure(q) : Batch(0.0), zeta = Batch(1.0);
  if (m.locking != Locking::mean) {
    const Batch J_minus_1 = m.locking == Locking::none ? k.J_minus_1 : s.shared_volume(q);
    p = law.pressure(J_minus_1, point_thermal_volume<Cell>(law, theta, q),
                     degradations(m, Batch(0.0), Batch(0.0)))
            .p;
  }
  if (m.locking == Locking::fbar) zeta = k.J / (Batch(1.0) + s.shared_volume(q));
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
  prepare<Cell, frame>(law, in.X, in.u, nullptr, in.theta, now, nullptr, 1, {in.patch, nullptr});
  prepare<Cell, frame>(law, in.X, in.u_n, nullptr, in.theta_n, before, nullptr, 1, {in.patch_n, nullptr});
  read_thickness<Cell, frame>(in.history, now);
  read_thickness<Cell, frame>(in.history_n, before);
  if constexpr (frame == Frame::plane_stress) std::ranges::copy(before.start_33, now.start_33);
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
