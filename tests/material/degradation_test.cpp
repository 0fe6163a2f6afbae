#include "../math/dense_matrix.hpp"
#include "rational_degradation.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <impact/material/degradation.hpp>

using namespace impact;
using Complex = std::complex<double>;

namespace {

/// g' by the complex step of g, g'' by that of g' from duals over complex numbers.
template <class Law> void expect_derivatives(const Law& law, double alpha) {
  const double h = 1e-30;
  for (int i = 0; i < 40; ++i) {
    const double phi = i / 40.0;
    const Degraded<double> g = differentiated(law, phi, alpha);
    EXPECT_NEAR(g.g, law(phi, alpha), 1e-15);
    EXPECT_NEAR(g.dg, law(Complex(phi, h), Complex(alpha)).imag() / h, 1e-13 * (1 + std::fabs(g.dg))) << phi;
    EXPECT_NEAR(g.d2g, differentiated(law, Complex(phi, h), Complex(alpha)).dg.imag() / h,
                1e-12 * (1 + std::fabs(g.d2g)))
        << phi;
    EXPECT_LE(g.dg, 0) << phi;
    const Degraded<Batch> lane = differentiated(law, Batch(phi), Batch(alpha));
    EXPECT_NEAR(lane.dg[0], g.dg, 1e-13 * (1 + std::fabs(g.dg)));
    EXPECT_NEAR(lane.d2g[0], g.d2g, 1e-12 * (1 + std::fabs(g.d2g)));
  }
  EXPECT_NEAR(law(0.0, alpha), 1, 1e-15);
  EXPECT_NEAR(law(1.0, alpha), 0, 1e-15);
}

/// Every law with a strength, at two lengths.
std::vector<MaterialParameters> cohesive_laws() {
  std::vector<MaterialParameters> laws;
  for (const Degradation ge :
       {Degradation::linear, Degradation::exponential, Degradation::cornelissen, Degradation::lorentz})
    for (const double gamma : {0.01, 0.04}) {
      MaterialParameters m;
      m.K = 20e9, m.G = 12e9, m.Gc = 100, m.gamma = gamma;
      m.damage = ge == Degradation::lorentz ? Damage::at1 : Damage::wu;
      m.ge = ge;
      m.cohesive = cohesive_shape(m, 1);
      m.cohesive.a1 = cohesive_slope(m, 3e6);
      laws.push_back(m);
    }
  return laws;
}

/// Largest of f over phi from 0 to 1.
template <class F> double largest(const F& f) {
  double most = -HUGE_VAL;
  for (int i = 0; i < 100000; ++i) most = std::fmax(most, f(i / 1e5));
  return most;
}

} // namespace

TEST(Degradation, DerivativesComeFromTheFormulaAlone) {
  expect_derivatives(QuadraticDegradation{}, 0);
  for (const double s : {1e-4, 0.5, 2.0}) expect_derivatives(CubicDegradation{s}, 0);
  for (const double alpha : {0.01, 0.04, 0.06, 0.1, 0.25}) expect_derivatives(DuctileDegradation{0.1}, alpha);
  for (const MaterialParameters& m : cohesive_laws()) expect_derivatives(CohesiveDegradation{m.cohesive}, 0);
}

TEST(Degradation, ALawOfOnesOwnNeedsOneFormula) {
  const RationalDegradation law{8.0, 0.5};
  expect_derivatives(law, 0);
  EXPECT_NEAR(differentiated(law, 0.0, 0.0).dg, -8, 1e-14); // g'(0) = -k
  const Degraded<double> kept = differentiated(law, 0.4, 0.0, 1e-3), plain = differentiated(law, 0.4, 0.0);
  EXPECT_NEAR(kept.g, 0.999 * plain.g + 1e-3, 1e-15);
  EXPECT_NEAR(kept.d2g, 0.999 * plain.d2g, 1e-13);
}

TEST(Degradation, QuadraticIsThatOfTheClosedForm) { // to the last bit
  MaterialParameters m;
  m.damage = Damage::at2;
  for (const double k : {0.0, 1e-6, 0.01}) {
    m.residual_stiffness = k;
    const double scale = 1 - k;
    for (double phi = -0.3; phi < 1.3; phi += 0.0371) {
      const Degraded<double> g = degradation(m, phi, 0.0);
      EXPECT_EQ(g.dg, (-2 * scale) * (1 - phi));
      EXPECT_EQ(g.d2g, 2 * scale);
      EXPECT_NEAR(g.g, scale * (1 - phi) * (1 - phi) + k, 2e-16 * (1 + g.g));
    }
  }
}

TEST(Degradation, DuctileWaitsForFlowAndIsFiniteAndSmoothToTheEnd) {
  const DuctileDegradation law{0.1};
  for (const double phi : {0.0, 0.3, 0.9}) {
    const Degraded<double> g = differentiated(law, phi, 0.0); // no flow: no damage
    EXPECT_EQ(g.g, 1);
    EXPECT_EQ(g.dg, 0);
    EXPECT_EQ(g.d2g, 0);
    EXPECT_NEAR(law(phi, 0.1), (1 - phi) * (1 - phi), 1e-15); // alpha_c: the quadratic law
  }
  for (const double alpha : {0.001, 0.03, 0.05, 0.09, 0.1, 0.3}) {
    double last = 2;
    for (double phi = 0.99; phi <= 1; phi += 1e-5) { // falls without end
      EXPECT_LE(law(phi, alpha), last);
      last = law(phi, alpha);
    }
    const Degraded<double> before = differentiated(law, 1 - 1.0000001e-3, alpha),
                           after = differentiated(law, 1 - 0.9999999e-3, alpha);
    EXPECT_NEAR(before.g, after.g, 1e-5 * before.g);
    EXPECT_NEAR(before.dg / after.dg, 1, 1e-5);
    for (const double phi : {1.0, 1.1, 2.0}) {
      const Degraded<double> g = differentiated(law, phi, alpha);
      EXPECT_TRUE(std::isfinite(g.g) && std::isfinite(g.dg) && std::isfinite(g.d2g));
    }
  }
}

TEST(Degradation, AStrengthIsWhatAPointBears) {
  // -g' E+ = w' G_c/gamma at the undamaged energy E+ = psi (e/e_c)^2 of a strain e: sigma = g E e
  for (MaterialParameters m : cohesive_laws()) {
    const double E = 9 * m.K * m.G / (3 * m.K + m.G), unit = m.Gc / m.gamma;
    m.residual_stiffness = 0;
    const auto stress = [&](double phi) {
      const Degraded<double> g = degradation(m, phi, 0.0);
      const Regularisation w = regularisation(m);
      return g.g * std::sqrt(2 * E * unit * (w.linear + w.quadratic * phi) / -g.dg);
    };
    EXPECT_NEAR(stress(0) / 3e6, 1, 1e-12);
    EXPECT_NEAR(largest(stress) / 3e6, 1, 1e-12);
  }
}

TEST(Degradation, AtTheLongestLengthAPointStillDamagesGraduallyAndNoLonger) {
  for (MaterialParameters m : cohesive_laws())
    for (const double part : {1.0001, 0.99}) {
      m.cohesive.a1 = part * least_cohesive_slope(m);
      const Regularisation w = regularisation(m);
      // the fall of the energy that a larger phi needs, over that energy
      const double fall = largest([&](double phi) {
        const Degraded<double> g = degradation(m, phi, 0.0);
        return -w.quadratic / -g.dg - (w.linear + w.quadratic * phi) * g.d2g / (g.dg * g.dg);
      });
      EXPECT_EQ(fall > 1e-9, part < 1) << int(m.ge);
      EXPECT_TRUE(is_convex(m));
      const double concave = largest([&](double phi) { return -degradation(m, phi, 0.0).d2g; });
      EXPECT_LE(part > 1 ? concave : 0, 0);
    }
}

TEST(Degradation, ThePowerEndsWhereTheCrackIsOpen) {
  for (const MaterialParameters& m : cohesive_laws())
    for (const double phi : {1.0, 1.0 + 1e-9, 1.2}) {
      const Degraded<double> g = degradation(m, phi, 0.0);
      EXPECT_TRUE(std::isfinite(g.g) && std::isfinite(g.dg) && std::isfinite(g.d2g));
      EXPECT_LT(g.g, 0.01);
    }
}
