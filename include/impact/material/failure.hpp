#pragma once
#include <impact/material/flow_stress.hpp>

/// Failure of a ductile material after G. R. Johnson and W. H. Cook, Fracture characteristics of three
/// metals, Engineering Fracture Mechanics 21, 1985: the measure D of a point grows with its plastic strain,
///   dD = dalpha/eps_f,   eps_f = (D1 + D2 exp(D3 sigma*)) (1 + D4 ln max(rate/rate_0, 1)) (1 + D5 T*) (55d)
/// or with (1 + rate/rate_0)^D4. sigma* = mean stress over that of von Mises, tension positive, so that D3 is
/// negative in most metals; T* is that of the flow stress, between 0 and 1. It has failed at D = 1.
namespace impact {

/// eps_f is not less than this, though D1 or D4 may be negative.
inline constexpr double least_failure_strain = 1e-6;

/// eps_f at a triaxiality, a rate of alpha and a temperature.
template <class T>
T failure_strain(const MaterialParameters& m, const T& triaxiality, const T& rate, const T& theta) {
  using V = Value<T>;
  // Beyond these bounds nothing fails, or everything at once, and exp would leave the numbers.
  const T exponent = m.jc_d3 * triaxiality, low = T(-50.0), high = T(50.0);
  const T bounded =
      select(value(exponent) < V(-50.0), low, select(value(exponent) > V(50.0), high, exponent));
  T strain = T(m.jc_d1) + m.jc_d2 * exp(bounded);
  if (m.jc_d4 != 0) strain = strain * rate_function(m, m.jc_d4, T((1 / m.rate_0) * rate));
  if (m.jc_d5 != 0) {
    const T x = (1 / (m.theta_melt - m.theta_ref)) * (theta - T(m.theta_ref));
    const T warm = select(value(x) > V(0.0), select(value(x) < V(1.0), x, T(1.0)), T(0.0));
    strain = strain * (T(1.0) + m.jc_d5 * warm);
  }
  return select(value(strain) > V(least_failure_strain), strain, T(least_failure_strain));
}

} // namespace impact
