#pragma once
#include <impact/material/crack.hpp>
#include <impact/material/drucker_prager.hpp>
#include <impact/math/dual.hpp>

/// Degradations of bodies whose strength f_t is given beside G_c and gamma (src/theory.md, (56'')):
///   g = (1 - phi)^p / ((1 - phi)^p + a_1 phi (1 + a_2 phi + a_2 a_3 phi^2)),   a_1 = w'(0) G_c/(gamma psi_c)
/// with the energy psi_c of the uniaxial stress f_t: damage begins there, whatever gamma. As gamma -> 0, and
/// nearly before, the stress over the opening of a crack is a softening law that p, a_2, a_3 tell and that
/// encloses the area G_c. With the local energy of Damage::wu (J.-Y. Wu, J. Mech. Phys. Solids 103 (2017)
/// 72):
///   linear       p = 2,    a_2 = -1/2,         a_3 = 0        f_t (1 - f_t d/2 G_c), to the last digit
///   exponential  p = 5/2,  a_2 = 2^(5/3) - 3,  a_3 = 0        f_t exp(-f_t d/G_c), within 0.003 f_t
///   cornelissen  p = 2,    a_2 = 1.3868,       a_3 = 0.6567   that of concrete, within 0.05 f_t
/// With that of Damage::at1 (E. Lorentz, S. Cuvilliez, K. Kazymyrenko, C. R. Mecanique 339 (2011) 20):
///   lorentz      p = 2,    a_2 > 0 is free,    a_3 = 0        the larger a_2, the steeper at first
namespace impact {

/// The formula. Beyond phi = 1 it stays finite: g' and g'' are 0 there unless p = 2.
struct CohesiveDegradation {
  static constexpr bool convex = true, ductile = false; ///< convex from a_1 = a_2 + p on
  CohesiveShape s;

  template <class T> T operator()(const T& phi, const T&) const {
    const T x = T(1.0) - phi, edge = T(1e-12);
    const T power = s.p == 2 ? x * x : pow(select(value(x) > value(edge), x, edge), s.p);
    return power / (power + s.a1 * (phi * (T(1.0) + s.a2 * (phi * (T(1.0) + s.a3 * phi)))));
  }
};

inline bool is_cohesive(Degradation ge) {
  return ge == Degradation::linear || ge == Degradation::exponential || ge == Degradation::cornelissen ||
         ge == Degradation::lorentz;
}

/// p, a_2, a_3 of the law that m.ge names; a_2 of Lorentz's is given.
inline CohesiveShape cohesive_shape(const DegradationParameters& m, double lorentz) {
  switch (m.ge) {
  case Degradation::exponential:
    return {.p = 2.5, .a2 = 0.17480210393640}; // 2^(5/3) - 3
  case Degradation::cornelissen:
    return {.a2 = 1.3868, .a3 = 0.6567};
  case Degradation::lorentz:
    return {.a2 = lorentz};
  default:
    return {.a2 = -0.5};
  }
}

/// E+ at the uniaxial stress f, small strains. The spectral split leaves the lateral contraction out, that
/// without tension what presses in the plane across once the crack is open.
inline double uniaxial_energy(const MaterialParameters& m, double f) {
  const double E = young_modulus(m), strain = f / E, volume = f / (3 * m.K);
  const double nu = 0.5 * E / m.G - 1;
  if (m.split == Split::no_tension) return 0.5 * f * strain * (1 - 2 * nu * nu / (1 - nu));
  if (m.split == Split::drucker_prager) return cone_energy(m, f);
  if (m.split != Split::spectral) return 0.5 * f * strain;
  return 0.5 * (m.K - 2 * m.G / 3) * volume * volume + m.G * strain * strain;
}

/// a_1 of the strength f.
inline double cohesive_slope(const MaterialParameters& m, double f) {
  return regularisation(m).linear * (m.Gc / m.gamma) / uniaxial_energy(m, f);
}

/// The least a_1 with which a point that is strained further damages gradually, at phi = 0 as anywhere: with
/// a smaller one, where gamma is too long, it would break at once.
inline double least_cohesive_slope(const MaterialParameters& m) {
  const Regularisation w = regularisation(m);
  return m.cohesive.a2 + m.cohesive.p - 0.5 * w.quadratic / w.linear;
}

} // namespace impact
