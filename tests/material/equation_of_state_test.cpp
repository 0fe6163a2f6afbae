#include "law_sampler.hpp"

#include <gtest/gtest.h>
#include <impact/material/point_law.hpp>

using namespace impact;
using reference::Complex;
using reference::Sampler;

namespace {

/// Of the internal energy all that hangs on the temperature.
double thermal_energy(const PointLaw& law, const ElasticVolume<double>& v, double g_v, double theta) {
  return law.parameters.c_v * (theta - law.parameters.theta0) + thermoelastic_energy(law, v, g_v, theta);
}

constexpr double tiny = 1e-30;

/// Copper: c_0 = 3940 m/s.
MaterialParameters copper(bool heats) {
  MaterialParameters m;
  m.rho = 8930;
  m.K = m.rho * 3940 * 3940;
  m.G = 47.7e9;
  m.equation_of_state = EquationOfState::mie_grueneisen;
  m.eos_s = 1.489;
  m.eos_gamma = heats ? 2.02 : 0;
  m.c_v = heats ? 8930 * 385.0 : 0;
  m.theta0 = 293;
  m.alpha_t = m.eos_gamma * m.c_v / (3 * m.K);
  return m;
}

PointLaw law_of(const MaterialParameters& m) { return {m}; }

double pressure_at(const MaterialParameters& m, double eta) { return -reference_curve(m, -eta).dU; }

/// psi of (52d) but for c_V [..], from the library's parts.
template <class T> T free_energy(const MaterialParameters& m, const T& J_minus_1, const T& theta, double g) {
  const ElasticVolume<T> v = elastic_volume(law_of(m), J_minus_1, theta);
  return volume_energy(law_of(m), v, T(value(v.Je_minus_1) < 0 ? 1.0 : g));
}

} // namespace

// Two equal plates that meet at 300 m/s: the jump of momentum gives rho_0 U_s u_p with u_p = 150 m/s.
TEST(EquationOfState, ShockOfCopperAt300MetresPerSecond) {
  const double u = 150, shock_speed = 3940 + 1.489 * u, p = 8930 * shock_speed * u;
  EXPECT_NEAR(p, 5.58e9, 0.01e9);
  EXPECT_NEAR(pressure_at(copper(false), u / shock_speed) / p, 1, 1e-13);
}

TEST(EquationOfState, PressureIsThatOfTheShockAndDerivesFromTheEnergy) {
  for (const bool heats : {false, true}) {
    const MaterialParameters m = copper(heats);
    for (double eta = -0.6; eta < 0.55; eta += 0.013) {
      const auto at = reference_curve(m, -eta);
      const auto z = reference_curve(m, Complex(-eta, tiny));
      EXPECT_NEAR(z.U.imag() / tiny / at.dU, 1, 1e-10) << eta;
      EXPECT_NEAR(z.dU.imag() / tiny / at.ddU, 1, 1e-12) << eta;
      EXPECT_GT(at.U, 0) << eta;
      EXPECT_GT(at.ddU, 0) << eta;
      const double p_H =
          eta > 0 ? 8930 * 3940.0 * 3940 * eta / std::pow(1 - 1.489 * eta, 2) : 8930 * 3940.0 * 3940 * eta;
      if (!heats) {
        EXPECT_NEAR(-at.dU / p_H, 1, 1e-13) << eta;
      }
    }
  }
}

// The two sides meet in value, slope and curvature; small strains keep their digits.
TEST(EquationOfState, SmallStrainsKeepTheirDigits) {
  for (const bool heats : {false, true}) {
    const MaterialParameters m = copper(heats);
    const double K = m.K - m.eos_gamma * m.eos_gamma * m.c_v * m.theta0;
    for (const double e : {1e-5, 1e-8, 1e-11})
      for (const double sign : {-1.0, 1.0}) {
        const auto at = reference_curve(m, sign * e);
        EXPECT_NEAR(at.U / (K / 2 * e * e), 1, 5 * e + 1e-14);
        EXPECT_NEAR(at.dU / (K * sign * e), 1, 5 * e + 1e-14);
        EXPECT_NEAR(at.ddU / K, 1, 10 * e + 1e-14);
      }
    EXPECT_EQ(reference_curve(m, 0.0).U, 0);
    EXPECT_EQ(reference_curve(m, 0.0).dU, 0);
  }
}

// The library's closed form and quadrature against the power series of the isentrope.
TEST(EquationOfState, CurveIsThatOfThePlainImplementation) {
  for (const bool heats : {false, true}) {
    const MaterialParameters m = copper(heats);
    for (double eta = -0.3; eta < 0.5; eta += 0.017) {
      const auto at = reference_curve(m, -eta);
      const auto plain = reference::isotherm(m, 1 - eta);
      EXPECT_NEAR(at.U / plain.U, 1, 1e-11) << eta;
      EXPECT_NEAR(at.dU / plain.dU, 1, 1e-11) << eta;
      EXPECT_NEAR(at.ddU / plain.ddU, 1, 1e-11) << eta;
    }
  }
}

// (52a) at any temperature and volume: psi gives pressure and internal energy, which obey it exactly.
TEST(EquationOfState, PressureAndInternalEnergyObeyMieAndGrueneisen) {
  const MaterialParameters m = copper(true);
  Sampler random(1);
  for (int trial = 0; trial < 300; ++trial) {
    const double eta = random.uniform(-0.2, 0.4), theta = random.uniform(200, 3000);
    const auto v = elastic_volume(law_of(m), -eta, theta);
    const double p = -volumetric_of_state(m, -eta, v.J_th).p;
    const double e = energy_of_state(m, v.Je_minus_1, v.J_th) + thermal_energy(law_of(m), v, 1.0, theta);
    const double y = eta > 0 ? 1 / (1 - m.eos_s * eta) : 1;
    EXPECT_NEAR(p, m.K * eta * y * y * (1 - m.eos_gamma * eta / 2) + m.eos_gamma * e, 1e-10 * m.K);
  }
}

// The state behind a shock, of which the jump of energy asks e = p eta/2, has the pressure of the shock.
TEST(EquationOfState, HeatedStateBehindAShockIsOnTheHugoniot) {
  const MaterialParameters m = copper(true);
  for (const double u : {100.0, 500.0, 1500.0}) {
    const double shock_speed = 3940 + 1.489 * u, eta = u / shock_speed, p = m.rho * shock_speed * u;
    double low = m.theta0, high = 1e5;
    for (int i = 0; i < 200; ++i) {
      const double theta = 0.5 * (low + high);
      const auto v = elastic_volume(law_of(m), -eta, theta);
      (energy_of_state(m, v.Je_minus_1, v.J_th) + thermal_energy(law_of(m), v, 1.0, theta) < p * eta / 2
           ? low
           : high) = theta;
    }
    EXPECT_NEAR(-volumetric_of_state(m, -eta, stress_free_volume(m, low)).p / p, 1, 1e-10) << u;
    // hotter than along the isentrope, where ln(theta/theta_0) = Gamma eta
    EXPECT_GT(low, m.theta0 * std::exp(m.eos_gamma * eta)) << u;
  }
}

TEST(EquationOfState, StressFreeVolumeHasNoStressAndGrowsByTheThermalPressure) {
  const MaterialParameters m = copper(true);
  EXPECT_EQ(stress_free_volume(m, m.theta0), 1);
  const double heat = m.eos_gamma * m.c_v, K = m.K - m.eos_gamma * heat * m.theta0;
  for (const double theta : {1.0, 100.0, 290.0, 294.0, 400.0, 1300.0, 9000.0}) {
    const double J = stress_free_volume(m, theta);
    EXPECT_NEAR(reference_curve(m, J - 1).dU, heat * (theta - m.theta0), 1e-14 * m.K);
    const auto z = stress_free_volume(m, Complex(theta, tiny));
    EXPECT_NEAR(z.imag() / tiny / (heat / reference_curve(m, J - 1).ddU), 1, 1e-12);
  }
  EXPECT_NEAR(stress_free_volume(m, Complex(m.theta0, tiny)).imag() / tiny / (heat / K), 1, 1e-13);
  Batch theta = 300;
  theta.set(1, 250), theta.set(2, 2000);
  for (int l = 0; l < lanes; ++l)
    EXPECT_NEAR(stress_free_volume(m, theta)[l], stress_free_volume(m, theta[l]), 1e-15);
}

// Damaged or not, in tension and compression: stress, entropy and capacity are derivatives of one energy.
TEST(EquationOfState, StressEntropyAndCapacityDeriveFromTheFreeEnergy) {
  const MaterialParameters m = copper(true);
  Sampler random(2);
  for (int trial = 0; trial < 300; ++trial) {
    const double g = trial % 3 ? 1 : 0.3, x = random.uniform(-0.15, 0.15), theta = random.uniform(200, 900);
    const auto v = elastic_volume(law_of(m), x, theta);
    const double g_v = v.Je_minus_1 < 0 ? 1 : g;
    EXPECT_GE(energy_of_state(m, v.Je_minus_1, v.J_th), 0);
    EXPECT_NEAR(free_energy(m, Complex(x, tiny), Complex(theta), g).imag() / tiny,
                g_v * volumetric_of_state(m, x, v.J_th).p, 1e-11 * m.K);
    EXPECT_NEAR(-free_energy(m, Complex(x), Complex(theta, tiny), g).imag() / tiny,
                thermoelastic_entropy(law_of(m), v, g_v), 1e-11 * m.c_v);
    const auto z = elastic_volume(law_of(m), Complex(x), Complex(theta, tiny));
    EXPECT_NEAR(m.c_v + theta * thermoelastic_entropy(law_of(m), z, Complex(g_v)).imag() / tiny,
                heat_capacity(law_of(m), v, g_v, theta), 1e-11 * m.c_v);
    EXPECT_NEAR(thermal_energy(law_of(m), v, g_v, theta) + g_v * energy_of_state(m, v.Je_minus_1, v.J_th),
                free_energy(m, x, theta, g) + theta * thermoelastic_entropy(law_of(m), v, g_v) +
                    m.c_v * (theta - m.theta0),
                1e-12 * m.K);
    if (g == 1) { // (52b), of which damage sees B alone
      const double U = reference_curve(m, x).U;
      EXPECT_NEAR(free_energy(m, x, theta, g), U - m.eos_gamma * m.c_v * (theta - m.theta0) * x, 1e-12 * m.K);
    }
  }
}

// Volumetric compression keeps its stiffness and drives nothing under the volumetric split.
TEST(EquationOfState, DamageLeavesCompressionAlone) {
  MaterialParameters m = copper(false);
  m.damage = Damage::at2, m.Gc = 1, m.gamma = 1;
  const PointLaw law = law_of(m);
  const auto g = degradations(m, 0.9, 0.0);
  const ElasticVolume<double> pressed{-0.1, 1}, pulled{0.1, 1};
  EXPECT_EQ(law.pressure(-0.1, 1.0, g).p, reference_curve(m, -0.1).dU);
  EXPECT_EQ(law.pressure(0.1, 1.0, g).p, g.e1.g * reference_curve(m, 0.1).dU);
  EXPECT_EQ(law.energies(0.0, pressed, 0.0).plus, 0);
  EXPECT_EQ(law.energies(0.0, pressed, 0.0).minus, reference_curve(m, -0.1).U);
  EXPECT_EQ(law.energies(0.0, pulled, 0.0).minus, 0);
}

TEST(EquationOfState, EndsWhereShocksCannotGoOn) {
  const MaterialParameters m = copper(false);
  EXPECT_TRUE(within_state(m, -0.67));
  EXPECT_FALSE(within_state(m, -0.68));
}
