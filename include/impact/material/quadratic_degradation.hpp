#pragma once

/// (1 - phi)^2: brittle fracture; damage begins with the load.
namespace impact {

struct QuadraticDegradation {
  static constexpr bool convex = true, ductile = false;

  template <class T> T operator()(const T& phi, const T&) const {
    const T x = T(1.0) - phi;
    return x * x;
  }
};

} // namespace impact
