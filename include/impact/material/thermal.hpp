#pragma once
#include <impact/material/elasticity.hpp>
#include <impact/material/parameters.hpp>
#include <impact/math/dual.hpp>

/// Thermal stretch (46): J_th = exp(3 alpha_t (theta - theta_0)), F^th = J_th^{1/3} 1, and what psi (48'),
/// (57') says of heat, per reference volume, with g_v the degradation of the volumetric energy:
///   eta   = -d psi/d theta = c_V ln(theta/theta_0) + s,   s = 3 alpha_t g_v K/2 (J_e^2 - 1)
///   e     = psi + theta eta; its thermal part is c_V (theta - theta_0) + theta s
///   c_eff = theta d eta/d theta = d e/d theta = c_V - 9 alpha_t^2 theta g_v K J_e^2
/// c_V is the capacity at fixed J_e, that of a body that expands freely.
namespace impact {

template <class T> T thermal_volume(const MaterialParameters& m, const T& theta) {
  return exp((3 * m.alpha_t) * (theta - T(m.theta0)));
}

/// s, the part of the entropy that comes with the volume.
template <class T> T thermoelastic_entropy(const MaterialParameters& m, const T& Je_minus_1, const T& g_v) {
  return (1.5 * m.alpha_t * m.K) * (g_v * (Je_minus_1 * (Je_minus_1 + T(2.0))));
}

/// ds/dJ = -dp/dtheta at fixed shape.
template <class T>
T entropy_slope(const MaterialParameters& m, const T& Je_minus_1, const T& J_th, const T& g_v) {
  return (3 * m.alpha_t * m.K) * (g_v * (T(1.0) + Je_minus_1) / J_th);
}

/// c_eff, the capacity at fixed strain.
template <class T>
T heat_capacity(const MaterialParameters& m, const T& Je_minus_1, const T& g_v, const T& theta) {
  const T Je = T(1.0) + Je_minus_1;
  return T(m.c_v) - (9 * m.alpha_t * m.alpha_t * m.K) * (theta * (g_v * (Je * Je)));
}

/// ln(theta/theta_n), accurate for small changes.
template <class T> T log_ratio(const T& theta, const T& theta_n) {
  const T x = (theta - theta_n) / theta_n;
  return x - log1p_excess(x);
}

/// Thermal part of the internal energy beside c_V (theta - theta_0).
template <class T>
T thermoelastic_energy(const MaterialParameters& m, const T& Je_minus_1, const T& g_v, const T& theta) {
  return theta * thermoelastic_entropy(m, Je_minus_1, g_v);
}

/// g_theta of the heat flux, from g_e1.
template <class T> T conduction_degradation(const MaterialParameters& m, const T& g_e1) {
  return m.damage == Damage::none || m.gtheta == ConductionDegradation::one ? T(1.0) : g_e1;
}

} // namespace impact
