#pragma once
#include <impact/material/hardening_curve.hpp>
#include <impact/material/parameters.hpp>
#include <impact/math/dual.hpp>

/// k_0 = sigma_y + r (1 - exp(-s alpha)) + H alpha and its potential, shifted so that H_0(0) = 0 (55').
namespace impact {

struct VoceHardening {
  static constexpr bool steep = false;

  /// With the slope: the two share the exponential, and most runs spend their time here.
  template <class T> static Hardening<T> curve(const MaterialParameters& m, const T& alpha) {
    if (m.voce_r == 0) return {T(m.sigma_y) + m.linear_h * alpha, T(m.linear_h)};
    const T e = exp((-m.voce_s) * alpha);
    return {T(m.sigma_y) + m.voce_r * (T(1.0) - e) + m.linear_h * alpha,
            (m.voce_r * m.voce_s) * e + T(m.linear_h)};
  }

  template <class T> static T potential(const MaterialParameters& m, const T& alpha) {
    T h = m.sigma_y * alpha + (0.5 * m.linear_h) * (alpha * alpha);
    if (m.voce_r != 0) {
      const T x = m.voce_s * alpha;
      h = h + (m.voce_r / m.voce_s) * (x + exp((-m.voce_s) * alpha) - T(1.0));
    }
    return h;
  }
};

} // namespace impact
