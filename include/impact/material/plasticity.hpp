#pragma once
#include <impact/material/elasticity.hpp>
#include <impact/material/parameters.hpp>
#include <impact/math/scalar_root.hpp>
#include <impact/math/tensor.hpp>

/// J2 flow with Voce and linear hardening (55), (64)-(69), by radial return on b = Fbar A Fbar^T.
namespace impact {

/// Flow stress k(alpha) = H_0' and its slope.
template <class T> struct Hardening { T k, dk; };
template <class T> Hardening<T> hardening(const MaterialParameters& m, const T& alpha) {
  if (m.voce_r == 0) return {T(m.sigma_y) + m.linear_h * alpha, T(m.linear_h)};
  const T e = exp((-m.voce_s) * alpha);
  return {T(m.sigma_y) + m.voce_r * (T(1.0) - e) + m.linear_h * alpha,
          (m.voce_r * m.voce_s) * e + T(m.linear_h)};
}

/// Plastic potential H_0(alpha), shifted so that H_0(0) = 0 (55').
template <class T> T plastic_potential(const MaterialParameters& m, const T& alpha) {
  T h = m.sigma_y * alpha + (0.5 * m.linear_h) * (alpha * alpha);
  if (m.voce_r != 0) {
    const T x = m.voce_s * alpha;
    h = h + (m.voce_r / m.voce_s) * (x + exp((-m.voce_s) * alpha) - T(1.0));
  }
  return h;
}

/// Outcome of the return in effective (undegraded) terms: tau_dev = g_e1 G dev_b.
template <class T, int d> struct Return {
  using Flag = decltype(value(T()) > value(T()));
  Symmetric<T, d> trial; ///< dev b_trial
  T y;                   ///< tr b_trial / 3
  Symmetric<T, d> dev_b; ///< scale * trial
  T scale;               ///< 1 - 2 mu dbeta / N, 1 where elastic
  T alpha;               ///< alpha_{n+1}
  T dbeta;               ///< plastic multiplier, 0 where elastic
  Flag plastic;          ///< lanes that flow
  int failed;            ///< lanes whose scalar equation did not converge
};

/// Predictor, admissibility, return (theory.md, return mapping). `ratio` = g_p/g_e1, the degraded yield
/// stress over the degraded modulus. e = F A F^T - 1 and J23 = J^(-2/3) define b_trial = J23 (1 + e). The
/// multiplier is found on values; one more step in T carries its derivative.
template <class T, int d>
Return<T, d> return_map(const MaterialParameters& m, const Symmetric<T, d>& e, const T& J23, const T& alpha_n,
                        const T& ratio) {
  using V = Value<T>;
  const double q = 0.81649658092772603273; // sqrt(2/3)
  Return<T, d> out;

  // predictor
  out.trial = J23 * dev(e);
  out.y = J23 * (T(1.0) + (1.0 / 3) * trace(e));
  out.dev_b = out.trial;
  out.scale = T(1.0);
  out.alpha = alpha_n;
  out.dbeta = T(0.0);
  out.failed = 0;

  // admissibility
  const T N = m.G * sqrt(dot(out.trial, out.trial)), mu = m.G * out.y;
  const Hardening<T> start = hardening(m, alpha_n);
  const V f = value(N) - value((q * ratio) * start.k);
  out.plastic = f > V(0.0);
  if (!any(out.plastic)) return out;

  // return
  const V Nv = value(N), muv = value(mu), a = value(alpha_n), c = value(ratio);
  const auto residual = [&](const V& x, V& slope) {
    const Hardening<V> h = hardening(m, V(a + q * x));
    slope = V(-2.0) * muv - (2.0 / 3) * (c * h.dk);
    return V(Nv - V(2.0) * muv * x - q * (c * h.k));
  };
  const V first = f / (V(2.0) * muv + (2.0 / 3) * (c * value(start.dk)));
  // A last step below 1e-4 of the root leaves an error of its square, and the step in T squares that again.
  const auto root = scalar_root(select(out.plastic, first, V(0.0)), V(0.0), V(V(0.5) * Nv / muv), out.plastic,
                                1e-4, residual);
  V slope;
  residual(root.x, slope);
  const T r = N - 2.0 * (mu * T(root.x)) - q * (ratio * hardening(m, T(alpha_n + T(q * root.x))).k);
  const T dbeta = differentiated_root(root.x, r, slope);
  out.failed = root.failed;
  out.dbeta = select(out.plastic, dbeta, T(0.0));
  out.scale = select(out.plastic, T(1.0) - 2.0 * (mu * dbeta) / N, T(1.0));
  out.dev_b = out.scale * out.trial;
  out.alpha = alpha_n + q * out.dbeta;
  return out;
}

} // namespace impact
