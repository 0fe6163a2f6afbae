#pragma once

/// (3 - s)(1 - phi)^2 - (2 - s)(1 - phi)^3, slope -s at phi = 0 (Borden et al. 2016): elastic until the
/// energy outweighs the crack's, then a sudden fall. Concave for phi below 1/2.
namespace impact {

struct CubicDegradation {
  static constexpr bool convex = false, ductile = false;
  double s;

  template <class T> T operator()(const T& phi, const T&) const {
    const T x = T(1.0) - phi;
    return x * x * (T(3 - s) - (2 - s) * x);
  }
};

} // namespace impact
