#pragma once
#include <impact/kernel/bulk_viscosity.hpp>
#include <impact/kernel/lumped_mass.hpp>
#include <impact/kernel/motion_input.hpp>
#include <impact/kernel/plane_stress.hpp>
#include <impact/kernel/spatial_map.hpp>

/// The longest stable step of central differences with lumped mass, cell by cell: no frequency of the bodies
/// is higher than the highest one of a cell that swings alone (B. Irons, G. Treharne, 1971), whose square is
/// at most C mu, with C the largest modulus of its points and mu the largest eigenvalue of
///   int g_a . g_b dV_0 / sqrt(m_a m_b)     g_a = dN_a/dx, m_a the cell's mass at node a
/// Damping by the velocity of the last step, of modulus D, leaves mu (C dt^2 + 2 D dt) <= 4.
namespace impact {

/// Bound of the largest eigenvalue of a symmetric matrix of n rows by the row sums of its eighth power; the
/// matrix is overwritten. At most n^(1/16) times the eigenvalue, exact where its vector has equal entries.
template <int n> inline Batch largest_eigenvalue(Batch (&A)[n][n]) {
  Batch B[n][n];
  const auto square = [](const Batch(&from)[n][n], Batch(&to)[n][n]) {
    for (int i = 0; i < n; ++i)
      for (int j = 0; j <= i; ++j)
        to[i][j] = to[j][i] = sum<n>([&](int k) { return from[i][k] * from[k][j]; });
  };
  square(A, B);
  square(B, A);
  square(A, B);
  Batch most = Batch(0.0);
  for (int i = 0; i < n; ++i) most = max(most, sum<n>([&](int j) { return abs(B[i][j]); }));
  return sqrt(sqrt(sqrt(most)));
}

/// (tr L)^2 <= this |L|^2 for the gradients L of velocities.
template <Frame frame> inline constexpr double directions = frame == Frame::plane_strain ? 2 : 3;

/// Bound of the largest eigenvalue of b = 1 + e, the exact one where the other two are equal.
template <int d> inline Batch largest_stretch(const Symmetric<Batch, d>& e) {
  const Batch mean = (1.0 / 3) * trace(e);
  return Batch(1.0) + mean + sqrt((2.0 / 3) * max(dot(e, e) - 3.0 * (mean * mean), Batch(0.0)));
}

/// Largest modulus of the Kirchhoff stress at a point, against any gradient of the velocity: of a change of
/// volume, or of shape, and the stress that is there. Flow and damage only make it smaller, but for the
/// pressure of the star-convex split.
template <class Cell, Frame frame, class Law>
inline Batch largest_modulus(const Law& law, const MotionInput& in, const Tensor<Batch, Cell::dim>& H,
                             const Batch& J, int q) {
  const MaterialParameters& m = law.parameters;
  const Degraded<Batch> one{Batch(1.0), Batch(0.0), Batch(0.0)};
  const Volumetric<Batch> v =
      warmed(law.pressure(J - Batch(1.0), point_thermal_volume<Cell>(law, in.theta, q), {one, one, one}),
             in.warming, J - Batch(1.0), q);
  Batch mean = Batch(1.0), most = Batch(1.0); // of what is elastic in b, of unit volume: tr b / 3, and the
                                              // largest eigenvalue
  if (!law.flows()) {
    const Batch r = inverse_cbrt(J);
    const Symmetric<Batch, Cell::dim> e = left_strain(H);
    mean = (r * r) * (Batch(1.0) + (1.0 / 3) * trace(e));
    most = (r * r) * largest_stretch(e);
  }
  const double stiffest = m.damage == Damage::none ? 1 : 1 + std::max(-compressed_share(m), 0.0); // g_2
  const Batch bulk = stiffest * max(J * (v.p + J * v.dp), Batch(0.0)), bent = (2 * m.G) * (mean - Batch(1.0));
  // An even change of area is a change of shape, too: |dev d|^2 = |d|^2/3.
  Batch volume = directions<frame> * bulk + ((2 - 2.0 / 3 * directions<frame>)*m.G) * mean + bent;
  if constexpr (frame ==
                Frame::plane_stress) { // the thickness gives way: E/(1 - nu) as long as strains are small
    const Batch G = m.G * mean;
    volume = min(volume, 18.0 * bulk * G / (3.0 * bulk + 4.0 * G) + (2 * m.G) * (most - Batch(1.0)));
  }
  return max(volume, m.G * (mean + most)) + J * abs(v.p);
}

template <class Cell, Frame frame, class Law> Batch stable_step_of(const Law& law, const MotionInput& in) {
  constexpr int d = Cell::dim, n = Cell::nodes;
  const auto& t = shape_table<Cell>;
  const MaterialParameters& m = law.parameters;
  CellState<Cell, frame> s;
  prepare<Cell, frame>(law, in.X, in.u, nullptr, in.theta, s);
  read_thickness<Cell, frame>(in.history, s);
  LumpedMass<Cell> mass;
  Batch A[n][n], C = Batch(0.0), D = Batch(0.0);
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) A[a][b] = Batch(0.0);
  for (int q = 0; q < Cell::points; ++q) {
    const Batch w = s.map[q].weight, J = Batch(1.0) + detm1(s.H[q]);
    const Tensor<Batch, d> F = plus_identity(s.H[q]);
    CurrentMap<Cell, frame> map;
    SpatialGradients<Cell, frame> G;
    current_map(s.map[q], inverse(F, J), map);
    spatial_gradients(map, t.N[q], t.dN[q], G);
    mass.add(q, m.rho, w);
    for (int a = 0; a < n; ++a)
      for (int b = 0; b <= a; ++b) {
        Batch product = sum<d>([&](int i) { return G.g[a][i] * G.g[b][i]; });
        if constexpr (frame == Frame::axisymmetric) product += G.ring[a] * G.ring[b];
        A[a][b] += w * product;
      }
    C = max(C, largest_modulus<Cell, frame>(law, in, s.H[q], J, q));
    if (law.viscous()) {
      const Batch b = largest_stretch(left_strain(s.H[q]));
      D = max(D, (4 * m.b_d) * (b * b));
    }
  }
  if (in.has_bulk_viscosity() && in.u_n) D += directions<frame> * bulk_rate(law, in, s).slope;
  mass.finish();
  for (int a = 0; a < n; ++a)
    for (int b = 0; b <= a; ++b) A[a][b] = A[b][a] = A[a][b] / sqrt(mass.at[a] * mass.at[b]);
  const Batch mu = largest_eigenvalue(A) / in.mass_factor;
  return (sqrt(D * D + 4.0 * C / mu) - D) / C;
}

/// Of each cell; in.u_n counts with bulk viscosity.
template <class Cell, Frame frame> Batch stable_step(const PointLaw& law, const MotionInput& in) {
  if constexpr (frame != Frame::plane_stress)
    if (has_state(law.parameters)) return stable_step_of<Cell, frame>(StateLaw(law), in);
  return stable_step_of<Cell, frame>(law, in);
}

} // namespace impact
