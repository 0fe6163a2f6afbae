#pragma once
#include <impact/kernel/bulk_viscosity.hpp>
#include <impact/kernel/lumped_mass.hpp>
#include <impact/kernel/motion_input.hpp>
#include <impact/kernel/plane_stress.hpp>
#include <impact/kernel/spatial_map.hpp>

/// How long a step of central differences with lumped mass may be, cell by cell: the square of the highest
/// frequency of a cell that swings alone is at most C mu, with C the largest modulus of its points and mu the
/// largest eigenvalue of
///   int g_a . g_b dV_0 / sqrt(m_a m_b)     g_a = dN_a/dx, m_a the cell's mass at node a
/// and at most A tau + S mu, with A (tr L)^2 + S |L|^2 for the modulus and tau the largest eigenvalue of
///   sqrt(w_p w_q) sum_a g_a(p) . g_a(q) / m_a     p, q points
/// Damping by the velocity of the last step, of modulus D, leaves mu (C dt^2 + 2 D dt) <= 4. No body swings
/// faster than the mean of its cells around a node, by their masses there (problem/stable_step.cpp).
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

/// The Kirchhoff stress at a point gives a gradient L of the velocity at most `any` |L|^2, and at most
/// trace (tr L)^2 + shape |L|^2.
struct Moduli {
  Batch any = 0, trace = 0, shape = 0;
};

/// Of a change of volume, or of shape, and the stress that is there. Flow and damage only make them smaller,
/// but for the pressure of the star-convex split.
template <class Cell, Frame frame>
inline Moduli largest_moduli(const PointLaw& law, const MotionInput& in, const Tensor<Batch, Cell::dim>& H,
                             const Batch& J, int q) {
  const MaterialParameters& m = law.parameters;
  const Degraded<Batch> one{Batch(1.0), Batch(0.0), Batch(0.0)};
  const Volumetric<Batch> v =
      warmed(law.pressure(J - Batch(1.0), point_thermal_volume<Cell>(law, in.theta, q), {one, one, one}),
             in.warming, J - Batch(1.0), q);
  Batch mean = Batch(1.0), most = Batch(1.0); // of what is elastic in b, of unit volume: tr b / 3, and the
                                              // largest eigenvalue
  Batch uneven = Batch(0.0);                  // |dev b|
  if (!law.flows()) {
    const Batch r = inverse_cbrt(J);
    const Symmetric<Batch, Cell::dim> e = left_strain(H);
    mean = (r * r) * (Batch(1.0) + (1.0 / 3) * trace(e));
    most = (r * r) * largest_stretch(e);
    uneven = (r * r) * sqrt(max(dot(e, e) - (1.0 / 3) * (trace(e) * trace(e)), Batch(0.0)));
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
  // Of W = G/2 tr b: |L|^2 (b_max + tr b/3) - 2/9 tr b (tr L)^2 - 4/3 tr L dev b : L, the last one at most
  // 2/3 |dev b| ((tr L)^2 + |L|^2).
  const Batch cross = (2.0 / 3 * m.G) * uneven, shape = m.G * (mean + most), there = J * abs(v.p);
  return {max(volume, shape) + there, max(bulk - (2.0 / 3 * m.G) * mean + cross, Batch(0.0)),
          shape + cross + there};
}

/// Of each cell, and where asked for its mass at its nodes; in.u_n counts with bulk viscosity.
template <class Cell, Frame frame>
CellFrequency highest_frequency(const PointLaw& law, const MotionInput& in, Batch* nodal_mass) {
  constexpr int d = Cell::dim, n = Cell::nodes;
  const auto& t = shape_table<Cell>;
  const MaterialParameters& m = law.parameters;
  CellState<Cell, frame> s;
  prepare<Cell, frame>(law, in.X, in.u, nullptr, in.theta, s);
  read_thickness<Cell, frame>(in.history, s);
  LumpedMass<Cell> mass;
  Batch A[n][n], D = Batch(0.0);
  Batch rate[Cell::points][n * d]; // tr L = sum of rate x over the dofs, times the root of the point's volume
  Moduli most;
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
    for (int a = 0; a < n; ++a)
      for (int i = 0; i < d; ++i) {
        rate[q][d * a + i] = sqrt(w) * G.g[a][i];
        if constexpr (frame == Frame::axisymmetric)
          if (i == 0) rate[q][d * a] += sqrt(w) * G.ring[a];
      }
    const Moduli here = largest_moduli<Cell, frame>(law, in, s.H[q], J, q);
    most = {max(most.any, here.any), max(most.trace, here.trace), max(most.shape, here.shape)};
    if (law.viscous()) {
      const Batch b = largest_stretch(left_strain(s.H[q]));
      D = max(D, (4 * m.b_d) * (b * b));
    }
  }
  if (in.has_bulk_viscosity() && in.u_n) D += directions<frame> * bulk_rate(law, in, s).slope;
  mass.finish();
  for (int a = 0; a < n; ++a)
    for (int b = 0; b <= a; ++b) A[a][b] = A[b][a] = A[a][b] / sqrt(mass.at[a] * mass.at[b]);
  Batch T[Cell::points][Cell::points];
  for (int p = 0; p < Cell::points; ++p)
    for (int q = 0; q <= p; ++q)
      T[p][q] = T[q][p] = sum<n * d>([&](int k) { return rate[p][k] * rate[q][k] / mass.at[k / d]; });
  const Batch mu = largest_eigenvalue(A) / in.mass_factor, tau = largest_eigenvalue(T) / in.mass_factor;
  if (nodal_mass != nullptr)
    for (int a = 0; a < n; ++a) nodal_mass[a] = mass.at[a] * in.mass_factor;
  const Batch any = mu * most.any;
  // The tr L of F-bar, at the centre, is in no sum of the points.
  const bool by_parts = m.locking != Locking::fbar;
  return {by_parts ? min(any, tau * most.trace + mu * most.shape) : any, mu * D, any};
}

} // namespace impact
