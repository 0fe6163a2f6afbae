#pragma once
#include <impact/material/parameters.hpp>
#include <impact/math/dual.hpp>

/// Degradation functions of the damage phi and their derivatives. Quadratic (1 - phi)^2, or Borden's cubic
/// (3-s)(1-phi)^2 - (2-s)(1-phi)^3; both keep the residual stiffness k: g -> (1-k) g + k.
namespace impact {

template <class T> struct Degraded {
  T g, dg, d2g; ///< value, first and second derivative
};

/// g_e1: deviatoric part and tensile volume.
template <class T> Degraded<T> degradation(const MaterialParameters& m, const T& phi) {
  const double scale = 1 - m.residual_stiffness;
  const T x = T(1.0) - phi;
  if (m.ge == Degradation::quadratic)
    return {scale * (x * x) + T(m.residual_stiffness), (-2 * scale) * x, T(2 * scale)};
  const double a = 3 - m.cubic_s, b = 2 - m.cubic_s;
  return {scale * (x * x * (T(a) - b * x)) + T(m.residual_stiffness), -scale * (x * (T(2 * a) - (3 * b) * x)),
          scale * (T(2 * a) - (6 * b) * x)};
}

/// g_e1, g_e2 (compressed volume) and g_p (plastic potential) at one point.
template <class T> struct Degradations { Degraded<T> e1, e2, p; };

template <class T> Degradations<T> degradations(const MaterialParameters& m, const T& phi) {
  const Degraded<T> one{T(1.0), T(0.0), T(0.0)};
  if (m.damage == Damage::none) return {one, one, one};
  const Degraded<T> e1 = degradation(m, phi);
  return {e1, m.split == Split::none ? e1 : one, m.gp == PlasticDegradation::ge ? e1 : one};
}

} // namespace impact
