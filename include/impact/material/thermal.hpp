#pragma once
#include <impact/material/parameters.hpp>
#include <impact/math/dual.hpp>

/// Thermal stretch (46): J_th = exp(3 alpha_t (theta - theta_0)), F^th = J_th^{1/3} 1.
namespace impact {

template <class T> T thermal_volume(const MaterialParameters& m, const T& theta) {
  return exp((3 * m.alpha_t) * (theta - T(m.theta0)));
}

} // namespace impact
