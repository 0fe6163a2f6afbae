#pragma once
#include <impact/material/point_law.hpp>
#include <impact/math/unroll.hpp>

/// Spatial moduli a_ijkl with  delta(P) F^T : grad w = grad w_ij a_ijkl grad du_kl, i.e. a_ijkl = c_ijkl +
/// delta_ik tau_jl (L_v tau = c : d) including the geometric part. Rows and columns are gradient components:
/// n = 4 (11 12 21 22, plane strain), 5 (+ 33, axisymmetric), 9 (row-major, solid).
namespace impact {

template <class T, int n> struct Modulus { T c[n][n]; };

/// The spatial dimension of the tensor layout, and the (i, j) of a gradient component.
template <int n> inline constexpr int layout_of = n == 9 ? 3 : 2;
template <int n> inline constexpr int row_of(int I) { return n == 9 ? I / 3 : I == 4 ? 2 : I / 2; }
template <int n> inline constexpr int column_of(int I) { return n == 9 ? I % 3 : I == 4 ? 2 : I % 2; }

template <class T, int n> Modulus<T, n> zero_modulus() {
  Modulus<T, n> a;
  for (int I = 0; I < n; ++I)
    for (int K = 0; K < n; ++K) a.c[I][K] = T(0.0);
  return a;
}

/// What the modulus of the law is made of, so that one pass writes each component once:
///   a = volume 1(x)1 - exchange il,jk + shear (ik,jl + il,jk) + B(x)1 + 1(x)B' - n(x)M - M'(x)n + delta_ik
///   tau_jl.
template <class T, int d> struct ModulusParts {
  T volume, exchange, shear;
  Symmetric<T, d> B, Bt; ///< factors of B(x)1 and 1(x)Bt
  Symmetric<T, d> tau;   ///< geometric stress
  bool flow;             ///< whether the plastic products n, M, Mt are present
  Symmetric<T, d> n, M, Mt;
};

template <int n, class T, int d> Modulus<T, n> assemble_modulus(const ModulusParts<T, d>& p) {
  Modulus<T, n> a;
  unroll<n>([&](auto row) {
    constexpr int I = row, i = row_of<n>(I), j = column_of<n>(I), ij = symmetric_index(d, i, j);
    unroll<n>([&](auto column) {
      constexpr int K = column, k = row_of<n>(K), l = column_of<n>(K), kl = symmetric_index(d, k, l);
      constexpr int jl = symmetric_index(d, j, l);
      T s = T(0.0);
      if constexpr (i == j && k == l) s = p.volume;
      if constexpr (i == k && j == l) s += p.shear;
      if constexpr (i == l && j == k) s += p.shear - p.exchange;
      if constexpr (k == l) s += p.B[ij];
      if constexpr (i == j) s += p.Bt[kl];
      if constexpr (i == k && jl >= 0) s += p.tau[jl];
      a.c[I][K] = s;
    });
  });
  if (!p.flow) return a;
  unroll<n>([&](auto row) {
    constexpr int I = row, ij = symmetric_index(d, row_of<n>(I), column_of<n>(I));
    unroll<n>([&](auto column) {
      constexpr int K = column, kl = symmetric_index(d, row_of<n>(K), column_of<n>(K));
      a.c[I][K] -= p.n[ij] * p.M[kl] + p.Mt[ij] * p.n[kl];
    });
  });
  return a;
}

/// Closed form of the neo-Hookean/J2 law (theory.md, consistent tangent). pJ = p J; dpJ2 = J^2 dp/dJ of the J
/// of the point (0 where p is held fixed); zeta and moving_zeta are the F-bar factor J/J_0 of the isochoric
/// stress (zeta = 1, false otherwise).
template <int n, class Law = MaterialHardening, class T, int d>
ModulusParts<T, d> law_modulus(const MaterialParameters& m, const Return<T, d>& flow, const T& g_e1,
                               const T& ratio, const T& pJ, const T& dpJ2, const T& zeta, bool moving_zeta,
                               bool symmetric) {
  ModulusParts<T, d> p;
  const T G = m.G * (zeta * g_e1), mu = G * flow.y;
  const Symmetric<T, d> s = G * flow.dev_b;
  p.shear = mu * flow.scale;
  p.volume = dpJ2 + pJ - (2.0 / 3) * p.shear;
  p.exchange = pJ;
  p.Bt = T(-2.0 / 3) * s;                    // (1 - d1) s_trial = s
  p.B = moving_zeta ? T(1.0 / 3) * s : p.Bt; // + s (x) 1 from d zeta = zeta tr(grad du)
  p.tau = s;
  p.flow = any(flow.plastic);
  if (!p.flow) return p;

  const T norm = sqrt(dot(flow.trial, flow.trial));
  const T inverse_norm = select(flow.plastic, T(1.0) / norm, T(0.0));
  p.n = inverse_norm * flow.trial;
  const T d0 = T(1.0) + ratio * flow_stress<Law>(m, flow).dk / ((3 * m.G) * flow.y);
  const T i0 = T(1.0) / d0, d1 = T(1.0) - flow.scale, Nmu = norm / flow.y;
  const T d2 = (T(1.0) - i0) * ((2.0 / 3) * (Nmu * flow.dbeta));
  const T d3 = i0 - d1 + d2, d4 = (i0 - d1) * Nmu;
  const T full = select(flow.plastic, 2.0 * mu, T(0.0));
  const Symmetric<T, d> n2 = dev(product(p.n, p.n));
  if (symmetric) {
    const T half = 0.5 * full;
    p.M = (half * d3) * p.n + (half * d4) * n2;
    p.Mt = p.M;
  } else {
    p.M = (full * d3) * p.n + (full * d4) * n2;
    p.Mt = T(0.0) * p.n;
  }
  return p;
}

/// Viscous part: c = 2 b_d/dt (B_ik B_jl + B_il B_jk) with B = F F^T; tau_d goes to the geometric stress.
template <int n, class T, int d>
void add_viscous(Modulus<T, n>& a, double factor, const Symmetric<T, d>& B, const T& g) {
  const T f = factor * g;
  unroll<n>([&](auto row) {
    constexpr int I = row, i = row_of<n>(I), j = column_of<n>(I);
    unroll<n>([&](auto column) {
      constexpr int K = column, k = row_of<n>(K), l = column_of<n>(K);
      constexpr int ik = symmetric_index(d, i, k), jl = symmetric_index(d, j, l);
      constexpr int il = symmetric_index(d, i, l), jk = symmetric_index(d, j, k);
      if constexpr (ik >= 0 && jl >= 0) a.c[I][K] += f * (B[ik] * B[jl]);
      if constexpr (il >= 0 && jk >= 0) a.c[I][K] += f * (B[il] * B[jk]);
    });
  });
}

/// Crack part: c = G_c gamma [delta_ik h_l h_j + delta_il h_k h_j + h_i delta_jk h_l + h_i delta_jl h_k].
template <int n, class T, int d> void add_crack(Modulus<T, n>& a, double factor, const Vector<T, d>& h) {
  unroll<n>([&](auto row) {
    constexpr int I = row, i = row_of<n>(I), j = column_of<n>(I);
    unroll<n>([&](auto column) {
      constexpr int K = column, k = row_of<n>(K), l = column_of<n>(K);
      if constexpr (i == k && l < d && j < d) a.c[I][K] += factor * (h[l] * h[j]);
      if constexpr (i == l && k < d && j < d) a.c[I][K] += factor * (h[k] * h[j]);
      if constexpr (j == k && i < d && l < d) a.c[I][K] += factor * (h[i] * h[l]);
      if constexpr (j == l && i < d && k < d) a.c[I][K] += factor * (h[i] * h[k]);
    });
  });
}

/// The modulus of any law f: Tensor<Dual<T,n>, d> H -> Symmetric<Dual<T,n>, d> tau by forward
/// differentiation. The derivatives with respect to Grad u are pushed forward: a_ijkl = (d P_iJ / d F_kL)
/// F_jJ F_lL.
template <int n, class T, int d, class F> Modulus<T, n> dual_modulus(const Tensor<T, d>& H, F&& tau_of) {
  using D = Dual<T, n>;
  Tensor<D, d> h;
  for (int I = 0; I < tensor_size(d); ++I) h[I] = I < n ? seed<T, n>(H[I], I) : D(H[I]);
  const Kinematics<D, d> k = kinematics(h);
  const Tensor<D, d> P = first_piola(tau_of(h), k.inverse_F);
  Modulus<T, n> a = zero_modulus<T, n>();
  for (int I = 0; I < n; ++I)
    for (int K = 0; K < n; ++K)
      for (int M = 0; M < n; ++M)
        for (int N = 0; N < n; ++N) {
          if (row_of<n>(M) != row_of<n>(I) || row_of<n>(N) != row_of<n>(K)) continue;
          const int j = tensor_index(d, column_of<n>(I), column_of<n>(M));
          const int l = tensor_index(d, column_of<n>(K), column_of<n>(N));
          if (j >= 0 && l >= 0) a.c[I][K] += P[M].d[N] * k.F[j].v * k.F[l].v;
        }
  return a;
}

} // namespace impact
