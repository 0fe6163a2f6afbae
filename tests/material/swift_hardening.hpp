#pragma once
#include <cmath>
#include <impact/material/hardening.hpp>

/// A hardening law of one's own, the sample of src/README.md: Swift's k_0 = K (e_0 + alpha)^n. No slope, no
/// tangent, no other file.
struct SwiftHardening {
  static constexpr double K = 7e8, e_0 = 0.01, n = 0.2;
  template <class T> static T stress(const impact::MaterialParameters&, const T& alpha) {
    return K * pow(T(e_0) + alpha, n);
  }
  template <class T> static T potential(const impact::MaterialParameters&, const T& alpha) {
    const T e = T(e_0) + alpha;
    return (K / (n + 1)) * (e * pow(e, n) - T(std::pow(e_0, n + 1)));
  }
};
