#pragma once
#include <impact/material/parameters.hpp>
#include <impact/math/dual.hpp>

/// k_0 = sigma_y + b alpha^n, the strain factor of Johnson and Cook (Ludwik's law).
namespace impact {

struct PowerHardening {
  template <class T> static T stress(const MaterialParameters& m, const T& alpha) {
    return T(m.sigma_y) + m.power_b * pow(alpha + T(tiny), m.power_n);
  }
  template <class T> static T potential(const MaterialParameters& m, const T& alpha) {
    return m.sigma_y * alpha +
           (m.power_b / (1 + m.power_n)) * ((alpha + T(tiny)) * pow(alpha + T(tiny), m.power_n));
  }

  /// Lost in any alpha that matters; keeps the slope at alpha = 0 a number.
  static constexpr double tiny = 1e-300;
};

} // namespace impact
