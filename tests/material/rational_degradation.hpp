#pragma once

/// A law of one's own, the sample of src/README.md: the rational degradation of Lorentz, Cuvilliez and
/// Kazymyrenko (2011), x^2/(x^2 + k phi (1 + p phi)) with x = 1 - phi. No derivative, no other file.
struct RationalDegradation {
  static constexpr bool convex = false, ductile = false;
  double k = 8, p = 0.5;

  template <class T> T operator()(const T& phi, const T& /*alpha*/) const {
    const T x = T(1.0) - phi;
    return x * x / (x * x + k * phi * (T(1.0) + p * phi));
  }
};
