#pragma once
#include <impact/material/elasticity.hpp>

/// The equation of state of Mie and Grueneisen for high pressure, per reference volume: with eta = 1 - J
///   pressure = p_H (1 - Gamma eta/2) + Gamma e,  p_H = K eta/(1 - s eta)^2,  K = rho_0 c_0^2   (52a)
/// p_H is the shock pressure of a material whose shocks run with U_s = c_0 + s u_p, and ends at s eta = 1. In
/// expansion s is 0. It derives from a free energy with constant Gamma rho and c_V, theta = theta_0 + h,
///   psi = U(J) - Gamma c_V h (J - 1) - c_V [theta ln(theta/theta_0) - h]   (52b)
///   U = E_s - c_V theta_0 (exp(Gamma eta) - 1 - Gamma eta), dE_s/deta = p_H (1 - Gamma eta/2) + Gamma E_s
/// with the energy E_s along the isentrope (52c) and U along the isotherm theta_0. Without heat Gamma is 0
/// and U the integral of p_H. In expansion E_s = K eta^2/2 for every Gamma. Damage wants an energy that is
/// least where the stress is zero, at the volume J_th of the temperature, U'(J_th) = Gamma c_V h:
///   psi = g_v B + M + ...,   p = g_v [U'(J) - U'(J_th)]   (52d)
///   B = U(J) - U(J_th) - U'(J_th)(J - J_th) >= 0,   M = U(J_th) - U'(J_th)(J_th - 1)
///
/// (M. A. Meyers, Dynamic Behavior of Materials, 1994, ch. 5; O. Heuze, General form of the Mie-Grueneisen
/// equation of state, Comptes Rendus Mecanique 340, 2012.)
namespace impact {

/// exp(x) - 1 - x, accurate for small x.
template <class T> T exp_excess(const T& x) {
  const auto large = abs(value(x)) > Value<T>(0.5);
  T series = T(1.0);
  for (int k = 16; k >= 3; --k) series = T(1.0) + (1.0 / k) * (x * series);
  const T near = 0.5 * (x * x) * series;
  if (!any(large)) return near;
  return select(large, exp(x) - T(1.0) - x, near);
}

/// U, dU/dJ and d2U/dJ2.
template <class T> struct ReferenceCurve { T U, dU, ddU; };

/// (E_H - E_s)/K on the isentrope, E_H = p_H eta/2: what a shock turns into heat, of third order,
///   exp(Gamma eta) int_0^eta exp(-Gamma x) s x^2/(1 - s x)^3 dx.
/// In v = -ln(1 - s x), of which the integrand is entire, Gauss's rule with ten points leaves less than 1e-14
/// of E_s up to s eta = 0.7 and 4e-11 at 0.9. `ratio` = s eta/(1 - s eta).
template <class T> T shock_heating(const MaterialParameters& m, const T& eta, const T& ratio) {
  constexpr double node[5] = {0.14887433898163122, 0.43339539412924719, 0.67940956829902441,
                              0.86506336668898451, 0.97390652851717172};
  constexpr double weight[5] = {0.29552422471475287, 0.26926671930999636, 0.21908636251598204,
                                0.14945134915058059, 0.066671344308688138};
  const double inverse_s = 1 / m.eos_s;
  const T end = ratio - log1p_excess(ratio); // -ln(1 - s eta)
  T sum = T(0.0);
  for (int i = 0; i < 10; ++i) {
    const T z = exp((0.5 * (i % 2 ? 1 + node[i / 2] : 1 - node[i / 2])) * end);
    const T x = inverse_s * (T(1.0) - T(1.0) / z), slope = z - T(1.0);
    sum += (0.5 * weight[i / 2]) * (slope * slope * exp(m.eos_gamma * (eta - x)));
  }
  return (inverse_s * inverse_s) * (end * sum);
}

/// Not inlined: a kernel asks for it several times, and exponentials cost more than a call.
template <class T>
[[gnu::noinline]] ReferenceCurve<T> reference_curve(const MaterialParameters& m, const T& J_minus_1) {
  const double K = m.K, s = m.eos_s, G = m.eos_gamma;
  const T eta = -J_minus_1;
  const auto pressed = value(eta) > Value<T>(0.0);
  const T squeeze = select(pressed, eta, T(0.0)), inverse = T(1.0) / (T(1.0) - s * squeeze);
  const T ratio = s * (squeeze * inverse), y = eta * inverse;
  const T p_H = K * (y * inverse);
  const T dp_H = K * ((T(1.0) + s * squeeze) * (inverse * inverse * inverse));
  if (G == 0) {
    const T linear = (0.5 * K) * (eta * eta);
    return {s == 0 ? linear : select(pressed, (K / (s * s)) * log1p_excess(ratio), linear), -p_H, dp_H};
  }
  T E = (0.5 * K) * (y * y);
  if (any(pressed)) E = E - K * shock_heating(m, squeeze, ratio);
  const T share = T(1.0) - (0.5 * G) * eta;
  const T p_s = p_H * share + G * E, dp_s = dp_H * share - (0.5 * G) * p_H + G * p_s;
  const double c = m.c_v * m.theta0;
  const T x = G * eta, excess = exp_excess(x);
  return {E - c * excess, (c * G) * (excess + x) - p_s, dp_s - (c * G * G) * (excess + x + T(1.0))};
}

/// J_th by Newton's method, J_th = 1 at theta_0.
template <class T> [[gnu::noinline]] T stress_free_volume(const MaterialParameters& m, const T& theta) {
  using V = Value<T>;
  const double heat = m.eos_gamma * m.c_v;
  const V h = V(heat) * (value(theta) - V(m.theta0)), lowest = V(m.eos_s > 0 ? -0.9 / m.eos_s : -0.9);
  V x = h / V(m.K - m.eos_gamma * heat * m.theta0);
  for (int it = 0; it < 50; ++it) {
    x = max(x, lowest);
    const ReferenceCurve<V> at = reference_curve(m, x);
    const V step = (at.dU - h) / at.ddU;
    x = x - step;
    // the last line squares the error that is left once more
    if (!any(abs(step) > V(1e-6) * abs(x) + V(1e-300))) break;
  }
  const ReferenceCurve<V> at = reference_curve(m, x);
  return T(1.0) + (T(x) - (T(at.dU) - heat * (theta - T(m.theta0))) * T(V(1.0) / at.ddU));
}

/// p of (52d) and dp/dJ, undegraded.
template <class T>
Volumetric<T> volumetric_of_state(const MaterialParameters& m, const T& J_minus_1, const T& J_th) {
  const ReferenceCurve<T> at = reference_curve(m, J_minus_1);
  Volumetric<T> v{(J_minus_1 - (J_th - T(1.0))) / J_th, at.dU, at.ddU};
  if (m.eos_gamma > 0) v.p = v.p - reference_curve(m, J_th - T(1.0)).dU;
  return v;
}

/// B of (52d).
template <class T> T energy_of_state(const MaterialParameters& m, const T& Je_minus_1, const T& J_th) {
  const T beyond = J_th * Je_minus_1; // J - J_th
  const T U = reference_curve(m, beyond + (J_th - T(1.0))).U;
  if (m.eos_gamma == 0) return U;
  const ReferenceCurve<T> free = reference_curve(m, J_th - T(1.0));
  const T B = U - free.U - free.dU * beyond;
  return select(value(B) > Value<T>(0.0), B, T(0.0)); // of rounding alone it may be negative
}

/// M of (52d), as a function of J_th.
template <class T> T energy_of_free_volume(const MaterialParameters& m, const T& J_th) {
  const ReferenceCurve<T> free = reference_curve(m, J_th - T(1.0));
  return free.U - free.dU * (J_th - T(1.0));
}

/// Whether a volume lies within the law: 1 - s eta > 0.
template <class T> auto within_state(const MaterialParameters& m, const T& J_minus_1) {
  return T(1.0) + m.eos_s * J_minus_1 > T(0.0);
}

//   s = Gamma c_V [g_v (J - J_th) + J_th - 1],   e = ... + g_v B + M + c_V (theta - theta_0) + theta s
//   c_eff = c_V + theta (1 - g_v) (Gamma c_V)^2/U''(J_th)                                            //
//   (57'')
// so that c_V is the capacity at fixed J of what is not damaged.
template <class T> T entropy_of_state(const MaterialParameters& m, const ElasticVolume<T>& v, const T& g_v) {
  return (m.eos_gamma * m.c_v) * (g_v * (v.J_th * v.Je_minus_1) + (v.J_th - T(1.0)));
}
template <class T>
T capacity_of_state(const MaterialParameters& m, const ElasticVolume<T>& v, const T& g_v, const T& theta) {
  const double heat = m.eos_gamma * m.c_v;
  return T(m.c_v) + (heat * heat) * (theta * (T(1.0) - g_v) / reference_curve(m, v.J_th - T(1.0)).ddU);
}

} // namespace impact
