#pragma once
#include <impact/material/parameters.hpp>
#include <impact/math/tensor.hpp>

/// Neo-Hookean energies per reference volume, (52)-(53): U = K/2 [(J_e^2 - 1)/2 - ln J_e], W = G/2 (tr b - 3)
/// with det b = 1, and the volumetric pressure. Everything is written in J_e - 1 and dev b, so that small
/// strains lose no digits.
namespace impact {

/// e - ln(1 + e), accurate for small e: with t = e/(2+e) it is e t - 2 t^3 (1/3 + t^2/5 + ...); the logarithm
/// itself where |e| > 0.3.
template <class T> T log1p_excess(const T& e) {
  const auto large = abs(value(e)) > Value<T>(0.3);
  const T t = e / (T(2.0) + e), t2 = t * t;
  T series = T(1.0 / 25);
  for (int k = 23; k >= 3; k -= 2) series = series * t2 + T(1.0 / k);
  const T near = e * t - 2.0 * (t * t2) * series;
  if (!any(large)) return near;
  return select(large, e - log(T(1.0) + e), near);
}

/// U as a function of J_e - 1.
template <class T> T volumetric_energy(const MaterialParameters& m, const T& Je_minus_1) {
  return (0.5 * m.K) * (0.5 * (Je_minus_1 * Je_minus_1) + log1p_excess(Je_minus_1));
}

/// J_e - 1 and J_th of a volume ratio at a temperature.
template <class T> struct ElasticVolume { T Je_minus_1, J_th; };

/// Pressure-like factor p = dU/dJ = U'(J_e)/J_th of the volumetric stress p cof F, and dp/dJ, undegraded.
template <class T> struct Volumetric { T Je_minus_1, p, dp; };
template <class T> Volumetric<T> volumetric(const MaterialParameters& m, const T& J_minus_1, const T& J_th) {
  const T inverse = T(1.0) / J_th;
  const T e = (J_minus_1 - (J_th - T(1.0))) * inverse;
  const T Je = T(1.0) + e, inverse_Je = T(1.0) / Je;
  return {e, (0.5 * m.K) * (e * (Je + T(1.0))) * (inverse_Je * inverse),
          (0.5 * m.K) * ((T(1.0) + inverse_Je * inverse_Je) * (inverse * inverse))};
}

/// z = tr b / 3 - 1 >= 0 of the unimodular b with the deviator d: root of (1+z)^3 - J2 (1+z) + J3 - 1 = 0
/// with J2 = d:d/2, J3 = det d, by Newton from `start` at or above the root, where the cubic is convex. No
/// cancellation: z is accurate relative to itself, and so is W = 3/2 G z.
template <class T, int d> T trace_excess(const Symmetric<T, d>& dev_b, const Value<T>& start) {
  using V = Value<T>;
  const T J2 = 0.5 * dot(dev_b, dev_b), J3 = det(dev_b);
  const V j2 = value(J2), j3 = value(J3);
  V z = start;
  for (int it = 0; it < 50; ++it) {
    const V y = V(1.0) + z;
    const V step = (z * (V(3.0) + z * (V(3.0) + z)) - j2 * y + j3) / (V(3.0) * y * y - j2);
    z = z - step;
    // the error left is a fraction z of the step's square, and the last line squares it again
    if (!any(abs(step) > V(1e-5) * abs(z) + V(1e-300))) break;
  }
  const V y = V(1.0) + z;
  const T r = T(z * (V(3.0) + z * (V(3.0) + z))) - J2 * T(y) + J3;
  return T(z) - r * T(V(1.0) / (V(3.0) * y * y - j2));
}

/// W of the unimodular b with trace 3 (1 + z).
template <class T> T isochoric_energy(const MaterialParameters& m, const T& z) { return (1.5 * m.G) * z; }

} // namespace impact
