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

} // namespace

TEST(Degradation, DerivativesComeFromTheFormulaAlone) {
  expect_derivatives(QuadraticDegradation{}, 0);
  for (const double s : {1e-4, 0.5, 2.0}) expect_derivatives(CubicDegradation{s}, 0);
  for (const double alpha : {0.01, 0.04, 0.06, 0.1, 0.25}) expect_derivatives(DuctileDegradation{0.1}, alpha);
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
