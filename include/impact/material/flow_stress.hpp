#pragma once
#include <impact/material/hardening.hpp>

/// k = k_0(alpha) f(theta) R(dalpha/dt) w(D) (55a), with f at the frozen temperature of the pass, the rate of
/// the step by backward Euler and the failure measure D at its start (55e).
namespace impact {

/// f(theta), the factor of the temperature on the flow stress (55a): never negative.
template <class T> T softening(const MaterialParameters& m, const T& theta) {
  using V = Value<T>;
  if (m.softening == Softening::none) return T(1.0);
  if (m.softening == Softening::linear) {
    const T f = T(1.0) - m.softening_w * (theta - T(m.theta0));
    return select(value(f) > V(0.0), f, T(0.0));
  }
  // T* = 0 below the reference temperature, 1 above that of melting.
  const T x = (1 / (m.theta_melt - m.theta_ref)) * (theta - T(m.theta_ref));
  const auto warm = value(x) > V(0.0);
  const T f = select(warm, T(1.0) - pow(select(warm, x, T(1.0)), m.softening_m), T(1.0));
  return select(value(f) > V(0.0), f, T(0.0));
}

/// 1 - D_c D, the factor of the failure measure on the flow stress (55e); D counts up to 1.
template <class T> T weakening(const MaterialParameters& m, const T& measure) {
  return T(1.0) - m.failure_softening * select(value(measure) < Value<T>(1.0), measure, T(1.0));
}

template <class T> struct FlowConditions {
  T softening = T(1.0); ///< f(theta) w(D)
  double dt = 0;        ///< 0: at rest, R = 1
  bool held = false;    ///< the history is that of the end of the step already: nothing flows
};

/// k hangs on alpha alone.
inline bool is_plain(const MaterialParameters& m) {
  return m.softening == Softening::none && m.rate_c == 0 && m.failure_softening == 0;
}

/// Whether k climbs by decades of alpha from the start of flow on, so that its root is looked for in those.
inline bool climbs_steeply(const MaterialParameters& m) {
  return is_steep(m) || (m.rate_c > 0 && m.rate_form == RateForm::power);
}

/// 1 + c ln(ratio) above 1 and 1 below, as in DynELA and Abaqus, or (1 + ratio)^c, of ratio = rate/rate_0.
template <class T> T rate_function(const MaterialParameters& m, double c, const T& ratio) {
  if (m.rate_form == RateForm::power) return pow(T(1.0) + ratio, c);
  return T(1.0) + c * log(select(value(ratio) > Value<T>(1.0), ratio, T(1.0)));
}

/// R and its slope along dalpha.
template <class T> Hardening<T> rate_factor(const MaterialParameters& m, double dt, const T& dalpha) {
  using V = Value<T>;
  if (m.rate_c == 0 || dt <= 0) return {T(1.0), T(0.0)};
  const double scale = 1 / (dt * m.rate_0);
  const T ratio = scale * dalpha, R = rate_function(m, m.rate_c, ratio);
  if (m.rate_form == RateForm::power) return {R, T(V(m.rate_c * scale) * value(R) / (V(1.0) + value(ratio)))};
  return {R, T(select(value(ratio) > V(1.0), V(m.rate_c) / value(dalpha), V(0.0)))};
}

/// k(alpha) and its slope along alpha = alpha_n + dalpha at the frozen temperature.
template <class T>
Hardening<T> flow_stress(const MaterialParameters& m, const FlowConditions<T>& at, const T& alpha,
                         const T& dalpha) {
  const Hardening<T> h = hardening(m, alpha);
  if (is_plain(m)) return h;
  const Hardening<T> R = rate_factor(m, at.dt, dalpha);
  return {at.softening * (h.k * R.k), at.softening * (h.dk * R.k + h.k * R.dk)};
}

/// k_d, the part of k that becomes heat: chi of what k would be at rest and all that the rate adds. k - k_d
/// is what psi_p keeps (theory.md 5).
template <class T>
T dissipative_stress(const MaterialParameters& m, const FlowConditions<T>& at, const T& alpha,
                     const T& dalpha) {
  const T k = hardening(m, alpha).k;
  if (is_plain(m)) return m.taylor_quinney * k;
  return at.softening * (k * (rate_factor(m, at.dt, dalpha).k - T(1 - m.taylor_quinney)));
}

} // namespace impact
