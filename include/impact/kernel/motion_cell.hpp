#pragma once
#include <impact/kernel/extra_stress.hpp>
#include <impact/kernel/motion_terms.hpp>
#include <impact/kernel/plane_stress.hpp>
#include <impact/kernel/spatial_map.hpp>

#include <impact/material/modulus.hpp>

/// Residual and tangent of the motion on one batch of cells.
namespace impact {

/// rho N_a N_b a_b into r and shift rho N_a N_b into K.
template <class Cell, Frame frame>
inline void add_inertia(const PointLaw& law, const MotionInput& in, const CellState<Cell, frame>& s, Batch* r,
                        Batch* K) {
  constexpr int d = Cell::dim, m = dofs<Cell>;
  const auto& N = shape_table<Cell>.N;
  for (int q = 0; q < Cell::points; ++q) {
    const Batch w = law.parameters.rho * s.map[q].weight;
    if (r && in.accel)
      for (int i = 0; i < d; ++i) {
        const Batch f = w * interpolate<Cell, d>(in.accel, q, i);
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

/// Rows of the modulus before that across a sheet is taken out.
constexpr int modulus_size(Frame frame) { return frame == Frame::plane_stress ? 5 : gradient_size(frame); }

/// The modulus of the law with the parts of the crack and of viscosity, without the thickness of a sheet.
template <Frame frame, int n, int d>
inline Modulus<Batch, gradient_size(frame)> completed(const PointLaw& law, const MotionInput& in,
                                                      const PointEvaluation<d>& e, Modulus<Batch, n> a,
                                                      const Vector<Batch, d>& h, const Tensor<Batch, d>& H) {
  if (law.crack_stress() && in.phi) add_crack(a, crack_flux(law.parameters), h);
  if (law.viscous() && in.u_n) {
    Symmetric<Batch, d> B = left_strain(H);
    for (int i = 0; i < 3; ++i) B[i] += Batch(1.0);
    add_viscous(a, 2 / in.dt, B, viscosity(law.parameters, e.g));
  }
  if constexpr (frame == Frame::plane_stress)
    return condensed(a);
  else
    return a;
}

/// a += delta_ik tau_jl.
template <int n, int d> inline void add_geometric(Modulus<Batch, n>& a, const Symmetric<Batch, d>& tau) {
  for (int I = 0; I < n; ++I)
    for (int K = 0; K < n; ++K)
      if (const int jl = symmetric_index(d, column_of<n>(I), column_of<n>(K));
          row_of<n>(I) == row_of<n>(K) && jl >= 0)
        a.c[I][K] += tau[jl];
}

/// Modulus at one point, all parts of the stress included. tau_extra = tau_phi + tau_d where there is any, h
/// = spatial gradient of phi. `coupling` takes what a cure of locking adds under a split by principal
/// stretches.
template <class Cell, Frame frame, class Evaluation, class Coupling>
inline Modulus<Batch, gradient_size(frame)>
modulus_at(const PointLaw& law, const MotionInput& in, const Evaluation& e,
           const Symmetric<Batch, Cell::dim>* tau_extra, const Vector<Batch, Cell::dim>& h,
           const Tensor<Batch, Cell::dim>& H, Coupling&& coupling) {
  constexpr int n = modulus_size(frame);
  const MaterialParameters& m = law.parameters;
  if constexpr (std::is_same_v<Evaluation, SplitEvaluation<Cell::dim>>) {
    const SplitModulus<n> split =
        split_modulus<n>(law, e.state, e.p * e.k.J, e.zeta, in.symmetric && m.locking != Locking::fbar);
    coupling(split);
    Modulus<Batch, n> a = split.a;
    if (tau_extra) add_geometric(a, *tau_extra);
    return completed<frame>(law, in, e, a, h, H);
  } else {
    const bool fbar = m.locking == Locking::fbar;
    const Batch J = e.k.J, dpJ2 = m.locking == Locking::none ? e.dp * (J * J) : Batch(0.0);
    ModulusParts<Batch, Cell::dim> parts = law_modulus<n>(
        m, e.flow, e.g.e1.g, e.g.p.g / e.g.e1.g, Batch(e.p * J), dpJ2, e.zeta, fbar, in.symmetric && !fbar);
    if (tau_extra) parts.tau = parts.tau + *tau_extra;
    return completed<frame>(law, in, e, assemble_modulus<n>(parts), h, H);
  }
}

/// The blocks below the diagonal from those above.
template <class Cell> inline void mirror(Batch* K) {
  constexpr int d = Cell::dim, m = dofs<Cell>;
  for (int a = 0; a < Cell::nodes; ++a)
    for (int b = 0; b < a; ++b)
      for (int i = 0; i < d; ++i)
        for (int j = 0; j < d; ++j) K[(a * d + i) * m + b * d + j] = K[(b * d + j) * m + a * d + i];
}

template <class Cell> inline void take_symmetric_part(Batch* K) {
  constexpr int m = dofs<Cell>;
  for (int i = 0; i < m; ++i)
    for (int j = 0; j < i; ++j) K[i * m + j] = K[j * m + i] = 0.5 * (K[i * m + j] + K[j * m + i]);
}

/// How the stress of a point moves with the volume ratio J_0 that the cure shares between the points. Mean
/// dilatation: K += (p'/V) v v^T with v_ai = int J g_ai dV_0, of several modes m_k K += v_k D_kl v_l^T with D
/// = M^-1 int p' m_k m_l dV_0 M^-1, M of VolumeModes. F-bar: dP/dJ_0 = -(J/J_0^2) P_dev + p'(J_0) cof F.
/// Under a split by principal stretches dev tau moves with the mean volume, too, and p with the points
/// (SplitModulus): K += (1/V) (r v^T + v t^T), M^-1 for 1/V.
template <class Cell, Frame frame, bool principal> struct VolumeCoupling {
  static constexpr int modes = volume_modes<Cell>, split_dofs = principal ? dofs<Cell> : 1;
  Batch row[modes][dofs<Cell>];                                ///< v, or dJ_0/du of the centroid
  Batch J_0;                                                   ///< of the centroid
  Batch force[modes][split_dofs], pressure[modes][split_dofs]; ///< r, t
  VolumeProducts<Cell> split_dp;                               ///< int dp/dJ_0 dV_0

  void start(const CellState<Cell, frame>& s, Locking locking) {
    for (int k = 0; k < modes; ++k) {
      for (Batch& x : row[k]) x = Batch(0.0);
      for (Batch& x : force[k]) x = Batch(0.0);
      for (Batch& x : pressure[k]) x = Batch(0.0);
    }
    split_dp.clear();
    if (locking != Locking::fbar) return;
    J_0 = Batch(1.0) + s.volume_J.of[0];
    CurrentMap<Cell, frame> map;
    SpatialGradients<Cell, frame> G;
    current_map(s.centre, inverse(plus_identity(s.centre_H), J_0), map);
    spatial_gradients(map, shape_table<Cell>.N0, shape_table<Cell>.dN0, G);
    for (int i = 0; i < dofs<Cell>; ++i) row[0][i] = J_0 * volume_slope(G, i);
  }
  void add_point(const CellState<Cell, frame>& s, const SpatialGradients<Cell, frame>& G, const Batch& J,
                 int q) {
    for (int i = 0; i < dofs<Cell>; ++i) add(s, row, q, i, J * volume_slope(G, i));
  }
  void add_split(const CellState<Cell, frame>& s, Locking locking,
                 const SplitModulus<modulus_size(frame)>& split, const SpatialGradients<Cell, frame>& G,
                 const Batch& weight, int q, Batch* K) {
    if (locking == Locking::fbar) add_tangent(split.dtau, G, weight, K);
    if (locking != Locking::mean) return;
    s.modes.add(split_dp, q, weight * split.dp);
    for (int i = 0; i < split_dofs; ++i) {
      add(s, force, q, i, weight * nodal_force(split.dtau, G, i));
      add(s, pressure, q, i, weight * nodal_force(split.dp_along, G, i));
    }
  }
  void add_tangent(const CellState<Cell, frame>& s, Batch* K) const {
    Batch D[modes][modes];
    if constexpr (modes == 1)
      D[0][0] = principal ? split_dp.of[0][0] / (s.modes.volume * s.modes.volume)
                          : s.mean_dp.of[0][0] / s.modes.volume;
    else
      s.modes.between(principal ? split_dp : s.mean_dp, D);
    for (int k = 0; k < modes; ++k) {
      // K += x v_k^T + v_k y^T, where x goes with J_0, by the pressure and the shape, and y with the shape
      // alone.
      Batch y[dofs<Cell>];
      for (int i = 0; i < dofs<Cell>; ++i) {
        Batch x = sum<modes>([&](int l) { return D[k][l] * row[l][i]; });
        if constexpr (principal) {
          x += s.modes.factor(k, force, i);
          y[i] = s.modes.factor(k, pressure, i);
        }
        add_row(x, row[k], i, K);
      }
      if constexpr (principal)
        for (int i = 0; i < dofs<Cell>; ++i) add_row(row[k][i], y, i, K);
    }
  }
  void add_tangent(const PointLaw& law, const PointEvaluation<Cell::dim>& e,
                   const SpatialGradients<Cell, frame>& G, const Batch& weight, Batch* K) const {
    constexpr int d = Cell::dim;
    Symmetric<Batch, d> dtau = (-law.parameters.G * (e.zeta * e.g.e1.g / J_0)) * e.flow.dev_b;
    for (int i = 0; i < 3; ++i) dtau[i] += e.dp * e.k.J;
    add_tangent(dtau, G, weight, K);
  }

private:
  void add_tangent(const Symmetric<Batch, Cell::dim>& dtau, const SpatialGradients<Cell, frame>& G,
                   const Batch& weight, Batch* K) const {
    for (int i = 0; i < dofs<Cell>; ++i) add_row(weight * nodal_force(dtau, G, i), row[0], i, K);
  }
  template <int n>
  static void add(const CellState<Cell, frame>& s, Batch (&rows)[modes][n], int q, int i,
                  const Batch& value) {
    rows[0][i] += value;
    for (int k = 1; k < modes; ++k) rows[k][i] += s.modes.place[q][k - 1] * value;
  }
  static Batch volume_slope(const SpatialGradients<Cell, frame>& G, int i) {
    return volume_gradient<Cell, frame>(G, i / Cell::dim, i % Cell::dim);
  }
  /// tau_ij g_a,j at the dof k = (a, i).
  static Batch nodal_force(const Symmetric<Batch, Cell::dim>& tau, const SpatialGradients<Cell, frame>& G,
                           int k) {
    constexpr int d = Cell::dim;
    const int a = k / d, i = k % d;
    Batch f = sum<d>([&](int j) { return tau[symmetric_index(d, i, j)] * G.g[a][j]; });
    if constexpr (frame == Frame::axisymmetric)
      if (i == 0) f += tau[2] * G.ring[a];
    return f;
  }
  static void add_row(const Batch& f, const Batch* y, int i, Batch* K) {
    for (int j = 0; j < dofs<Cell>; ++j) K[i * dofs<Cell> + j] += f * y[j];
  }
};

template <class Cell, Frame frame, bool tangent, bool principal>
inline CellStatus motion(const PointLaw& law, const MotionInput& in, Batch* r, Batch* K) {
  constexpr int d = Cell::dim, m = dofs<Cell>;
  const auto& t = shape_table<Cell>;
  const Locking locking = law.parameters.locking;
  const bool upper = locking != Locking::fbar && (in.symmetric || !law.flows());
  const bool extra = (law.crack_stress() && in.phi) || (law.viscous() && in.u_n);
  const bool mean = locking == Locking::mean && !(is_linear_simplex<Cell> && in.patch);
  CellStatus status{0, Batch(1e300)};
  CellStateOf<Cell, frame, principal> s;
  prepare<Cell, frame>(law, in.X, in.u, in.phi, in.theta, s, in.history, in.unilateral,
                       {in.patch, in.patch_pressure, in.warming});
  status.bad |= share_unknowns<Cell, frame, principal>(law, in, s);
  Fluxes<Cell, frame> fluxes;
  VolumeCoupling<Cell, frame, principal> coupling;
  if constexpr (tangent) {
    for (int i = 0; i < m * m; ++i) K[i] = Batch(0.0);
    if (locking != Locking::none) coupling.start(s, locking);
  }
  for (int q = 0; q < Cell::points; ++q) {
    const auto e = evaluate_point<Cell, frame, principal>(law, in, s, q);
    note<Cell, frame>(status, law, s, e, q);
    const Batch w = s.map[q].weight;
    CurrentMap<Cell, frame> map;
    current_map(s.map[q], e.k.inverse_F, map);
    Vector<Batch, d> h;
    Symmetric<Batch, d> tau_extra;
    if (extra) tau_extra = extra_stress<Cell, frame>(law, in, s, e, q, h);
    fluxes.set(q, map, w, extra ? e.tau + tau_extra : e.tau);
    if constexpr (tangent) {
      SpatialGradients<Cell, frame> G;
      spatial_gradients(map, t.N[q], t.dN[q], G);
      const auto a = modulus_at<Cell, frame>(
          law, in, e, extra ? &tau_extra : nullptr, h, s.H[q],
          [&](const auto& split) { coupling.add_split(s, locking, split, G, w, q, K); });
      if (upper)
        add_stiffness<Cell, frame, true>(G, a, w, K);
      else
        add_stiffness<Cell, frame, false>(G, a, w, K);
      if (mean) coupling.add_point(s, G, w * e.k.J, q);
      if (!principal && locking == Locking::fbar) coupling.add_tangent(law, e, G, w, K);
    }
  }
  if (r) fluxes.add_forces(r);
  if constexpr (tangent)
    if (mean) coupling.add_tangent(s, K);
  if (in.accel || (tangent && in.mass_shift != 0))
    add_inertia<Cell, frame>(law, in, s, r, tangent ? K : nullptr);

  Batch finite = Batch(0.0);
  if (r)
    for (int i = 0; i < m; ++i) finite += r[i] - r[i];
  if constexpr (tangent) {
    for (int i = 0; i < m; ++i) finite += K[i * m + i] - K[i * m + i];
    if (upper) mirror<Cell>(K);
    if (locking == Locking::fbar && in.symmetric) take_symmetric_part<Cell>(K);
  }
  status.bad |= bits(~is_finite(finite));
  return status;
}

/// Flattened: everything is inlined here, so that tensors of a point live in registers (twice as fast).
template <class Cell, Frame frame, bool tangent, Terms terms>
[[gnu::flatten, gnu::noinline]] CellStatus motion_with(const PointLaw& law, const MotionInput& in, Batch* r,
                                                       Batch* K) {
  const LastDigits kept;
  return motion<Cell, frame, tangent, terms == Terms::principal>(restricted<terms>(law),
                                                                 restricted(in, terms), r, K);
}

template <class Cell, Frame frame>
CellStatus motion_residual(const PointLaw& law, const MotionInput& in, Batch* r) {
  return with_terms<Cell, frame>(terms_of(law, in), [&](auto terms) {
    return motion_with<Cell, frame, false, terms>(law, in, r, nullptr);
  });
}

template <class Cell, Frame frame>
CellStatus motion_tangent(const PointLaw& law, const MotionInput& in, Batch* r, Batch* K) {
  return with_terms<Cell, frame>(
      terms_of(law, in), [&](auto terms) { return motion_with<Cell, frame, true, terms>(law, in, r, K); });
}

} // namespace impact
