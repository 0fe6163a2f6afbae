#pragma once
#include "motion_point.hpp"

#include <impact/material/modulus.hpp>

/// Residual, tangent and advance of one batch of cells; instantiated in motion_<shape>.cpp.
namespace impact {

template <class Cell> inline constexpr int dofs = Cell::nodes* Cell::dim;

/// Spatial gradients g_a = F^-T Grad N_a of the shape functions, with N_a/r in the axisymmetric frame.
template <class Cell, Frame frame> struct SpatialGradients {
  Batch g[Cell::nodes][Cell::dim];
  Batch ring[frame == Frame::axisymmetric ? Cell::nodes : 1];
};

template <class Cell, Frame frame>
inline void spatial_gradients(const PointGeometry<Cell, frame>& X, const Tensor<Batch, Cell::dim>& inverse_F,
                              SpatialGradients<Cell, frame>& out) {
  constexpr int d = Cell::dim;
  for (int a = 0; a < Cell::nodes; ++a)
    for (int i = 0; i < d; ++i) {
      Batch s = X.dN[a][0] * inverse_F[i];
      for (int j = 1; j < d; ++j) s += X.dN[a][j] * inverse_F[d * j + i];
      out.g[a][i] = s;
    }
  if constexpr (frame == Frame::axisymmetric)
    for (int a = 0; a < Cell::nodes; ++a) out.ring[a] = X.ring[a] * inverse_F[4];
}

/// r_ai += w P_iJ N_a,J
template <class Cell, Frame frame>
inline void add_force(const PointGeometry<Cell, frame>& X, const Tensor<Batch, Cell::dim>& P, Batch* r) {
  constexpr int d = Cell::dim;
  Tensor<Batch, d> wP;
  for (int i = 0; i < tensor_size(d); ++i) wP[i] = X.weight * P[i];
  for (int a = 0; a < Cell::nodes; ++a)
    for (int i = 0; i < d; ++i) {
      Batch s = wP[d * i] * X.dN[a][0];
      for (int j = 1; j < d; ++j) s += wP[d * i + j] * X.dN[a][j];
      if constexpr (frame == Frame::axisymmetric)
        if (i == 0) s += wP[4] * X.ring[a];
      r[a * d + i] += s;
    }
}

/// K_ai,bk += w g_a,j a_ij,kl g_b,l; only blocks a <= b where `upper`.
template <class Cell, Frame frame>
inline void add_stiffness(const SpatialGradients<Cell, frame>& G,
                          const Modulus<Batch, gradient_size(frame)>& a, const Batch& weight, bool upper,
                          Batch* K) {
  constexpr int d = Cell::dim, n = gradient_size(frame), m = dofs<Cell>;
  for (int b = 0; b < Cell::nodes; ++b) {
    Batch D[n][d]; // w a_I,kl g_b,l
    for (int I = 0; I < n; ++I)
      for (int k = 0; k < d; ++k) {
        Batch s = a.c[I][d * k] * G.g[b][0];
        for (int l = 1; l < d; ++l) s += a.c[I][d * k + l] * G.g[b][l];
        if constexpr (frame == Frame::axisymmetric)
          if (k == 0) s += a.c[I][4] * G.ring[b];
        D[I][k] = weight * s;
      }
    const int last = upper ? b + 1 : Cell::nodes;
    for (int c = 0; c < last; ++c)
      for (int i = 0; i < d; ++i)
        for (int k = 0; k < d; ++k) {
          Batch s = G.g[c][0] * D[d * i][k];
          for (int j = 1; j < d; ++j) s += G.g[c][j] * D[d * i + j][k];
          if constexpr (frame == Frame::axisymmetric)
            if (i == 0) s += G.ring[c] * D[4][k];
          K[(c * d + i) * m + b * d + k] += s;
        }
  }
}

/// v_ai: derivative of the volume ratio J with respect to u_ai, J g_a.
template <class Cell, Frame frame>
inline Batch volume_gradient(const SpatialGradients<Cell, frame>& G, int a, int i) {
  if constexpr (frame == Frame::axisymmetric)
    if (i == 0) return G.g[a][0] + G.ring[a];
  return G.g[a][i];
}

/// rho N_a N_b a_b into r and shift rho N_a N_b into K.
template <class Cell, Frame frame>
inline void add_inertia(const PointLaw& law, const MotionInput& in, const CellState<Cell, frame>& s, Batch* r,
                        Batch* K) {
  constexpr int d = Cell::dim, m = dofs<Cell>;
  const auto& N = shape_table<Cell>.N;
  for (int q = 0; q < Cell::points; ++q) {
    const Batch w = law.parameters.rho * s.geometry[q].weight;
    if (in.accel)
      for (int i = 0; i < d; ++i) {
        const Batch f = w * interpolate<Cell>(in.accel, q, i);
        for (int a = 0; a < Cell::nodes; ++a) r[a * d + i] += N[q][a] * f;
      }
    if (K && in.mass_shift != 0)
      for (int a = 0; a < Cell::nodes; ++a)
        for (int b = 0; b < Cell::nodes; ++b) {
          const Batch f = (in.mass_shift * N[q][a] * N[q][b]) * w;
          for (int i = 0; i < d; ++i) K[(a * d + i) * m + b * d + i] += f;
        }
  }
}

/// Modulus at one point, all parts of the stress included. tau_extra = tau_phi + tau_d, h = spatial gradient
/// of phi.
template <class Cell, Frame frame>
inline Modulus<Batch, gradient_size(frame)>
modulus_at(const PointLaw& law, const MotionInput& in, const PointEvaluation<Cell::dim>& e,
           const Symmetric<Batch, Cell::dim>& tau_extra, const Vector<Batch, Cell::dim>& h,
           const Tensor<Batch, Cell::dim>& H) {
  constexpr int n = gradient_size(frame);
  const MaterialParameters& m = law.parameters;
  const bool fbar = m.locking == Locking::fbar;
  const Batch J = e.k.J, dpJ2 = m.locking == Locking::none ? e.dp * (J * J) : Batch(0.0);
  ModulusParts<Batch, Cell::dim> parts = law_modulus<n>(
      m, e.flow, e.g.e1.g, e.g.p.g / e.g.e1.g, Batch(e.p * J), dpJ2, e.zeta, fbar, in.symmetric && !fbar);
  parts.tau = parts.tau + tau_extra;
  Modulus<Batch, n> a = assemble_modulus<n>(parts);
  if (law.crack_stress() && in.phi) add_crack(a, m.Gc * m.gamma, h);
  if (law.viscous() && in.u_n) {
    Symmetric<Batch, Cell::dim> B = left_strain(H);
    for (int i = 0; i < 3; ++i) B[i] += Batch(1.0);
    add_viscous(a, 2 / in.dt, B, viscosity(m, e.g));
  }
  return a;
}

/// Adds the local blocks to the caller's matrix; `upper` fills the lower blocks by symmetry, `average` takes
/// the symmetric part.
template <class Cell> inline void add_matrix(const Batch* k, bool upper, bool average, Batch* K) {
  constexpr int d = Cell::dim, m = dofs<Cell>;
  for (int a = 0; a < Cell::nodes; ++a)
    for (int b = 0; b < Cell::nodes; ++b)
      for (int i = 0; i < d; ++i)
        for (int j = 0; j < d; ++j) {
          const int here = (a * d + i) * m + b * d + j, there = (b * d + j) * m + a * d + i;
          if (average)
            K[here] += 0.5 * (k[here] + k[there]);
          else
            K[here] += k[upper && a > b ? there : here];
        }
}

/// Flattened: everything is inlined here, so that tensors of a point live in registers (twice as fast).
template <class Cell, Frame frame, bool tangent>
[[gnu::flatten]] CellStatus motion(const PointLaw& law, const MotionInput& in, Batch* r_out, Batch* K_out) {
  constexpr int d = Cell::dim, m = dofs<Cell>;
  const Locking locking = law.parameters.locking;
  const bool fbar = locking == Locking::fbar, mean = locking == Locking::mean;
  const bool upper = !fbar && (in.symmetric || !law.flows());
  CellStatus status{0, Batch(1e300)};
  CellState<Cell, frame> s;
  prepare<Cell, frame>(law, in.X, in.u, in.phi, in.theta, s);

  Batch r[m], K[tangent ? m * m : 1], volume_row[tangent ? m : 1], centre_row[tangent ? m : 1];
  for (int i = 0; i < m; ++i) r[i] = Batch(0.0);
  if constexpr (tangent) {
    for (int i = 0; i < m * m; ++i) K[i] = Batch(0.0);
    for (int i = 0; i < m; ++i) volume_row[i] = Batch(0.0);
    if (fbar) {
      SpatialGradients<Cell, frame> G;
      const Batch J_0 = Batch(1.0) + s.volume_J;
      spatial_gradients<Cell, frame>(s.centre, inverse(plus_identity(s.centre_H), J_0), G);
      for (int a = 0; a < Cell::nodes; ++a)
        for (int i = 0; i < d; ++i) centre_row[a * d + i] = J_0 * volume_gradient<Cell, frame>(G, a, i);
    }
  }
  for (int q = 0; q < Cell::points; ++q) {
    const PointEvaluation<d> e = evaluate_point<Cell, frame>(law, in, s, q);
    note(status, e);
    Vector<Batch, d> h;
    const bool extra = (law.crack_stress() && in.phi) || (law.viscous() && in.u_n);
    const Symmetric<Batch, d> tau_extra =
        extra ? extra_stress<Cell, frame>(law, in, s, e, q, h) : Batch(0.0) * e.tau;
    add_force<Cell, frame>(s.geometry[q], first_piola(extra ? e.tau + tau_extra : e.tau, e.k.inverse_F), r);
    if constexpr (tangent) {
      SpatialGradients<Cell, frame> G;
      spatial_gradients<Cell, frame>(s.geometry[q], e.k.inverse_F, G);
      const auto a = modulus_at<Cell, frame>(law, in, e, tau_extra, h, s.H[q]);
      const Batch w = s.geometry[q].weight, wJ = w * e.k.J;
      add_stiffness<Cell, frame>(G, a, w, upper, K);
      if (mean)
        for (int b = 0; b < Cell::nodes; ++b)
          for (int i = 0; i < d; ++i) volume_row[b * d + i] += wJ * volume_gradient<Cell, frame>(G, b, i);
      if (fbar) { // dP/dJ_0 = -(J/J_0^2) P_dev + p'(J_0) cof F
        Batch force[m];
        for (int i = 0; i < m; ++i) force[i] = Batch(0.0);
        const Batch J_0 = Batch(1.0) + s.volume_J;
        Symmetric<Batch, d> dtau = (-law.parameters.G * (e.zeta * e.g.e1.g / J_0)) * e.flow.dev_b;
        for (int i = 0; i < 3; ++i) dtau[i] += e.dp * e.k.J;
        add_force<Cell, frame>(s.geometry[q], first_piola(dtau, e.k.inverse_F), force);
        for (int i = 0; i < m; ++i)
          for (int j = 0; j < m; ++j) K[i * m + j] += force[i] * centre_row[j];
      }
    }
  }
  if constexpr (tangent)
    if (mean) {
      const Batch factor = s.mean_dp / s.volume;
      for (int i = 0; i < m; ++i) {
        const Batch f = factor * volume_row[i];
        for (int j = 0; j < m; ++j) K[i * m + j] += f * volume_row[j];
      }
    }
  if (in.accel || (tangent && in.mass_shift != 0))
    add_inertia<Cell, frame>(law, in, s, r, tangent ? K : nullptr);

  Batch finite = Batch(0.0);
  for (int i = 0; i < m; ++i) {
    finite += r[i] - r[i];
    r_out[i] += r[i];
  }
  status.bad |= bits(~is_finite(finite));
  if constexpr (tangent) add_matrix<Cell>(K, upper, fbar && in.symmetric, K_out);
  return status;
}

template <class Cell, Frame frame>
CellStatus motion_residual(const PointLaw& law, const MotionInput& in, Batch* r) {
  return motion<Cell, frame, false>(law, in, r, nullptr);
}

template <class Cell, Frame frame>
CellStatus motion_tangent(const PointLaw& law, const MotionInput& in, Batch* r, Batch* K) {
  return motion<Cell, frame, true>(law, in, r, K);
}

template <class Cell, Frame frame>
[[gnu::flatten]] CellStatus motion_advance(const PointLaw& law, const MotionInput& in, Batch* trial_history,
                                           Batch* drive, StepSums& sums) {
  constexpr int d = Cell::dim;
  const MaterialParameters& m = law.parameters;
  CellStatus status{0, Batch(1e300)};
  CellState<Cell, frame> s;
  prepare<Cell, frame>(law, in.X, in.u, in.phi, in.theta, s);
  for (int q = 0; q < Cell::points; ++q) {
    const PointEvaluation<d> e = evaluate_point<Cell, frame>(law, in, s, q);
    note(status, e);
    const PointHistory<Batch, d> old = read_history<d>(law, in.history, q);
    const Batch z_trial = e.flow.y - Batch(1.0);
    const Batch z = trace_excess(e.flow.dev_b, z_trial), w = s.geometry[q].weight;
    const PointHistory<Batch, d> now = law.updated(e.k, old, e.flow, z);
    const PointEnergies<Batch> energy = law.energies(z, e.Je_minus_1, now.alpha);
    if (trial_history) {
      for (int i = 0; i < symmetric_size(d); ++i) trial_history[q * history_size(d) + i] = now.A[i];
      trial_history[q * history_size(d) + symmetric_size(d)] = now.alpha;
    }
    if (drive) {
      drive[q * drive_size] = energy.plus;
      drive[q * drive_size + 1] = energy.minus;
      drive[q * drive_size + 2] = energy.plastic;
    }
    status.bad |= bits(~is_finite(energy.plus + energy.minus + energy.plastic));
    if (law.flows()) {
      const Batch k_d = m.taylor_quinney * hardening(m, now.alpha).k;
      sums.plastic_dissipation += w * (e.g.p.g * (k_d * (now.alpha - old.alpha)));
      const Batch released = isochoric_energy(m, trace_excess(e.flow.trial, z_trial) - z);
      sums.plastic_work += w * (e.g.e1.g * select(e.flow.plastic, released, Batch(0.0)));
    }
    if (law.viscous() && in.u_n) {
      const auto dC = step_of_C<Cell, frame>(s.geometry[q], s.H[q], e.k.F, in.u_n);
      sums.viscous_dissipation += w * ((1 / in.dt) * (viscosity(m, e.g) * dot(dC, dC)));
    }
  }
  return status;
}

} // namespace impact
