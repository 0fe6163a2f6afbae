#pragma once
#include <impact/material/spectral_split.hpp>

/// Damage whose strength grows with pressure (L. De Lorenzis, C. Maurini, Int. J. Fract. 237 (2022) 61;
/// Y. Navidtehrani, C. Betegon, E. Martinez-Paneda, Theor. Appl. Mech. Lett. 12 (2022) 100338), at finite
/// strains: what a broken point keeps is the least energy that it can have when its debris may shear and
/// dilate until sqrt(J_2) + B I_1 = 0. The published energies are quadratic in tr eps and sqrt(J_2(eps)); U
/// and W are exactly that in
///   U = K/2 v^2,   W = 2 G j^2,   v = tr eps, j = sqrt(J_2(eps)) at small strains,
/// so that with D = 2 G + 18 B^2 K and the measure c = 2 G j + 3 B K v, sqrt(J_2) + B I_1 of the stress,
///   E+ = U + W and E- = 0          where v >= 6 B j: the debris hangs together nowhere
///   E+ = 0 and E- = U + W          where c <= 0
///   E+ = c^2/D, E- = K G/D (v - 6 B j)^2   between them,                                       (50'''')
/// with continuous stresses. Sound material damages at a given c: that is Drucker and Prager's cone. A crack
/// opens by a strain in one direction, v = sqrt(3) j, and bears nothing as long as 6 B <= sqrt(3): strengths
/// that differ by 3 at most.
namespace impact {

/// v and dv/dln J_e of x = J_e - 1: v = x s with s^2 = 2 U/(K x^2).
template <class T> struct VolumeMeasure { T v, slope; };
template <class T> VolumeMeasure<T> volume_measure(const T& x) {
  using V = Value<T>;
  const auto small = abs(value(x)) < V(1e-5);
  const T safe = select(small, T(1.0), x);
  const T s = select(small, T(1.0) + x * (x * T(1.0 / 9) - T(1.0 / 6)),
                     sqrt(T(0.5) + log1p_excess(safe) / (safe * safe)));
  return {x * s, (T(1.0) + 0.5 * x) / s};
}

/// Of e = b_e - 1 and dJ = J_e - 1.
template <class T, int d>
SplitEnergies<T, d> drucker_prager_energies(const MaterialParameters& m, const Symmetric<T, d>& e,
                                            const T& dJ) {
  using V = Value<T>;
  const T Je = T(1.0) + dJ, c = inverse_cbrt(Je);
  const Symmetric<T, d> dev_b = (c * c) * dev(e);
  const V start = abs(value(T(c * c * (T(1.0) + (1.0 / 3) * trace(e))) - T(1.0)));
  const T z = trace_excess(dev_b, start), least = T(1e-300);
  const T j = sqrt(0.75 * select(value(z) > value(least), z, least));
  const VolumeMeasure<T> volume = volume_measure(dJ);
  const double B = m.cone, D = 2 * m.G + 18 * B * B * m.K;
  const T excess = (2 * m.G) * j + (3 * B * m.K) * volume.v, kept = volume.v - (6 * B) * j;
  const auto open = value(kept) >= V(0.0), closed = value(excess) <= V(0.0);
  const T zero = T(0.0), one = T(1.0), all = volumetric_energy(m, dJ) + isochoric_energy(m, z);
  const auto pick = [&](const T& if_open, const T& if_closed, const T& between) {
    return select(open, if_open, select(closed, if_closed, between));
  };
  const T pressure = (0.5 * m.K) * (dJ * (Je + one)); // of U: J_e U'
  // The shares of the stresses of W and U: derivatives of E+ and E- with respect to j and v.
  const T sheared = pick(one, zero, excess / (D * j));
  const T up = pick(pressure, zero, (6 * B * m.K / D) * (excess * volume.slope));
  SplitEnergies<T, d> s;
  s.plus = pick(all, zero, (1 / D) * (excess * excess));
  s.minus = pick(zero, all, (m.K * m.G / D) * (kept * kept));
  s.tau_plus = (m.G * sheared) * dev_b;
  s.tau_minus = pick(zero, T(m.G), (-6 * B * m.K * m.G / D) * (kept / (2.0 * j))) * dev_b;
  const T down = pick(zero, pressure, (2 * m.K * m.G / D) * (kept * volume.slope));
  for (int i = 0; i < 3; ++i) {
    s.tau_plus[i] = s.tau_plus[i] + up;
    s.tau_minus[i] = s.tau_minus[i] + down;
  }
  return s;
}

/// B of the ratio r of the uniaxial strengths in compression and in tension: (r - 1)/(r + 1)/sqrt(3), the
/// cone's, or with less than what uniaxial tension opens, v < 6 B j, of (1/sqrt(3) - B)^2 r^2 = D/(2 E).
inline double cone_of(const MaterialParameters& m, double ratio) {
  const double E = young_modulus(m), root3 = std::sqrt(3.0);
  const double B = (ratio - 1) / (ratio + 1) / root3;
  if (6 * B * E / (2 * root3 * m.G) >= E / (3 * m.K)) return B;
  const double r2 = ratio * ratio, a = r2 - 9 * m.K / E, b = 2 * r2 / root3, c0 = r2 / 3 - m.G / E;
  return 2 * c0 / (b + std::sqrt(b * b - 4 * a * c0)); // the smaller root
}

/// The least ratio, of B = 0, where volume alone is kept.
inline double least_strength_ratio(const MaterialParameters& m) {
  return std::sqrt(3 * m.G * (3 * m.K + m.G) / (9 * m.K * m.G));
}

/// E+ at the uniaxial stress f of either sign, small strains.
inline double cone_energy(const MaterialParameters& m, double f) {
  const double E = young_modulus(m), v = f / (3 * m.K), root3 = std::sqrt(3.0);
  const double j = std::fabs(f) / (2 * root3 * m.G), B = m.cone;
  if (v >= 6 * B * j) return 0.5 * f * f / E;
  const double excess = std::max(0.0, std::fabs(f) / root3 + B * f);
  return excess * excess / (2 * m.G + 18 * B * B * m.K);
}

} // namespace impact
