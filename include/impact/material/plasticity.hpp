#pragma once
#include <impact/material/elasticity.hpp>
#include <impact/material/flow_stress.hpp>
#include <impact/material/parameters.hpp>
#include <impact/math/scalar_root.hpp>
#include <impact/math/tensor.hpp>

/// J2 flow (64), (66), (67') by radial return on b = Fbar A Fbar^T, for any flow stress.
namespace impact {

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
  FlowConditions<T> at;  ///< what the flow stress was asked for
};

/// The elastic predictor: what stays where nothing flows. e = F A F^T - 1 and J23 = J^(-2/3).
template <class T, int d>
Return<T, d> predictor(const Symmetric<T, d>& e, const T& J23, const T& alpha_n,
                       const FlowConditions<T>& at) {
  Return<T, d> out;
  out.trial = out.dev_b = J23 * dev(e);
  out.y = J23 * (T(1.0) + (1.0 / 3) * trace(e));
  out.scale = T(1.0);
  out.alpha = alpha_n;
  out.dbeta = T(0.0);
  out.plastic = value(J23) < value(J23);
  out.failed = 0;
  out.at = at;
  return out;
}

/// What drives the flow against the multiplier x: N - 2 mu x, the norm of dev b = (1 - 2 mu x/N) trial times
/// G.
template <class T> struct RadialStress {
  using V = Value<T>;
  T N, mu;

  V start() const { return value(N); }
  V stiffness() const { return V(2.0) * value(mu); }
  V at(const V& x, V& slope) const {
    slope = V(-2.0) * value(mu);
    return value(N) - V(2.0) * value(mu) * x;
  }
  T at(const T& x) const { return N - 2.0 * (mu * x); }
};

/// The flow stress that the parameters name, and Voce's at rest and at one temperature.
struct AnyFlow {
  template <class T>
  static Hardening<T> stress(const MaterialParameters& m, const FlowConditions<T>& at, const T& alpha,
                             const T& dalpha) {
    return flow_stress(m, at, alpha, dalpha);
  }
  static bool climbs(const MaterialParameters& m) { return climbs_steeply(m); }
};
struct VoceFlow {
  template <class T>
  static Hardening<T> stress(const MaterialParameters& m, const FlowConditions<T>&, const T& alpha,
                             const T&) {
    return VoceHardening::curve(m, alpha);
  }
  static bool climbs(const MaterialParameters&) { return false; }
};

/// Admissibility and return from the predictor `out` along its deviator. The multiplier is found on values;
/// one more step in T carries its derivative.
template <class Flow, class T, int d, class Stress>
void flow_back(const MaterialParameters& m, Return<T, d>& out, const Stress& stress, const T& ratio) {
  using V = Value<T>;
  const double q = 0.81649658092772603273; // sqrt(2/3)
  const FlowConditions<T> at = out.at;
  const T alpha_n = out.alpha;

  // admissibility
  const Hardening<T> start = Flow::stress(m, FlowConditions<T>{at.softening, 0, false}, alpha_n, T(0.0));
  const V f = stress.start() - value((q * ratio) * start.k);
  out.plastic = at.held ? f < f : f > V(0.0);
  if (!any(out.plastic)) return;

  // return
  const V a = value(alpha_n), c = value(ratio);
  const FlowConditions<V> conditions{value(at.softening), at.dt, at.held};
  const auto residual = [&](const V& x, V& slope) {
    const Hardening<V> h = Flow::stress(m, conditions, V(a + q * x), V(q * x));
    const V driven = stress.at(x, slope);
    slope = slope - (2.0 / 3) * (c * h.dk);
    return V(driven - q * (c * h.k));
  };
  const V first = f / (stress.stiffness() + (2.0 / 3) * (c * value(start.dk)));
  const V high = V(0.5) * value(stress.N) / value(stress.mu);
  // A last step below 1e-4 of the root leaves an error of its square, and the step in T squares that again. A
  // steep slope, which is not corrected by that step, asks for one more.
  // Where k' may be infinite at alpha = 0, `first` is 0 and the root anywhere above.
  const bool climbs = Flow::climbs(m);
  const V noise = V(4e-15) * value(stress.N), low = climbs ? V(V(1e-280) * high) : V(0.0);
  const V guess = climbs ? max(first, V(V(1e-6) * high)) : first;
  const ScalarRoot<V> root = scalar_root(select(out.plastic, guess, V(0.0)), low, high, out.plastic,
                                         climbs ? 1e-8 : 1e-4, residual, climbs ? &noise : nullptr);
  V slope;
  residual(root.x, slope);
  const T r =
      stress.at(T(root.x)) - q * (ratio * Flow::stress(m, at, T(alpha_n + T(q * root.x)), T(q * root.x)).k);
  const T dbeta = differentiated_root(root.x, r, slope);
  out.failed = root.failed;
  out.dbeta = select(out.plastic, dbeta, T(0.0));
  out.scale = select(out.plastic, T(1.0) - 2.0 * (stress.mu * dbeta) / stress.N, T(1.0));
  out.dev_b = out.scale * out.trial;
  out.alpha = alpha_n + q * out.dbeta;
}

/// Not inlined: the laws with their powers are long, and a kernel would hold them several times.
template <class T, int d, class Stress>
[[gnu::noinline, gnu::flatten]] void flow_back_of_any(const MaterialParameters& m, Return<T, d>& out,
                                                      const Stress& stress, const T& ratio) {
  flow_back<AnyFlow>(m, out, stress, ratio);
}

/// Predictor, admissibility, return (theory.md, return mapping). `ratio` = g_p/g_e1, the degraded yield
/// stress over the degraded modulus. e = F A F^T - 1 and J23 = J^(-2/3) define b_trial = J23 (1 + e).
template <class T, int d>
Return<T, d> return_map(const MaterialParameters& m, const Symmetric<T, d>& e, const T& J23, const T& alpha_n,
                        const T& ratio, const FlowConditions<T>& at = {}) {
  Return<T, d> out = predictor(e, J23, alpha_n, at);
  const RadialStress<T> stress{m.G * sqrt(dot(out.trial, out.trial)), m.G * out.y};
  if (m.hardening == HardeningKind::voce && is_plain(m))
    flow_back<VoceFlow>(m, out, stress, ratio);
  else
    flow_back_of_any(m, out, stress, ratio);
  return out;
}

/// The flow stress and its slope where the return ended.
template <class T, int d> Hardening<T> flow_stress(const MaterialParameters& m, const Return<T, d>& flow) {
  return flow_stress(m, flow.at, flow.alpha, T(0.81649658092772603273 * flow.dbeta));
}

} // namespace impact
