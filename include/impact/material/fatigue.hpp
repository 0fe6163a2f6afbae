#pragma once
#include <impact/material/parameters.hpp>
#include <impact/math/dual.hpp>

/// Fatigue: a variable Fat (energy per area, like G_c) with the free energy psi_F = Fat H_f(phi)/gamma, H_f =
/// -phi on [0, 1], 0 below and -1 above (48'), and the law of growth
///   dFat/dt = -(Fhat/gamma) H_f,   Fhat = a (1 - phi) |1/2 (S_c + S_d) : Cdot|,  S_c that of the undamaged
///   body (F1)
/// which makes its dissipation -(1/gamma) H_f dFat/dt = Fhat (H_f/gamma)^2 (25'). Over a step phi is that of
/// its end, so that Fat grows by growth(phi, |work|), the work per volume of the step, and what is stored and
/// dissipated changes by psi_F(phi, Fat) - psi_F(phi, Fat_n) = -dissipation(phi, Fat - Fat_n) exactly.
namespace impact {

/// H_f(phi).
template <class T> T fatigue_activity(const T& phi) {
  const T above = select(value(phi) > Value<T>(0.0), phi, T(0.0));
  return -select(value(above) < Value<T>(1.0), above, T(1.0));
}

/// psi_F per reference volume.
template <class T> T fatigue_energy(const MaterialParameters& m, const T& phi, const T& fatigue) {
  return (1 / m.gamma) * (fatigue * fatigue_activity(phi));
}

/// Fat - Fat_n for the stress power of the step, of either sign.
template <class T> T fatigue_growth(const MaterialParameters& m, const T& phi, const T& work) {
  const T H = fatigue_activity(phi), size = select(value(work) < Value<T>(0.0), -work, work);
  return (-m.fatigue_a / m.gamma) * ((T(1.0) + H) * (H * size));
}

/// Energy per reference volume that growth by `growth` dissipates.
template <class T> T fatigue_dissipation(const MaterialParameters& m, const T& phi, const T& growth) {
  return (-1 / m.gamma) * (fatigue_activity(phi) * growth);
}

} // namespace impact
