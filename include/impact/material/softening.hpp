#pragma once
#include <impact/material/parameters.hpp>
#include <impact/math/dual.hpp>

/// f(theta), the factor of the temperature on the flow stress (55a): never negative.
namespace impact {

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

} // namespace impact
