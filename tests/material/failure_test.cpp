#include <gtest/gtest.h>
#include <impact/material/failure.hpp>
#include <impact/math/batch.hpp>

using namespace impact;

namespace {

/// OFHC copper of Johnson and Cook (1985).
MaterialParameters copper() {
  MaterialParameters m;
  m.jc_failure = true;
  m.jc_d1 = 0.54, m.jc_d2 = 4.89, m.jc_d3 = -3.03, m.jc_d4 = 0.014, m.jc_d5 = 1.12;
  m.rate_0 = 1, m.theta_ref = 293, m.theta_melt = 1356;
  return m;
}

} // namespace

TEST(Failure, StrainIsThatOfTheFormula) {
  const MaterialParameters m = copper();
  // 0.54 + 4.89 exp(-1.01) = 2.32103 in tension; 14.0 times as much by exp(1.01) when pressed
  EXPECT_NEAR(failure_strain(m, 1.0 / 3, 1.0, 293.0), 2.32103, 1e-5);
  EXPECT_NEAR(failure_strain(m, -1.0 / 3, 1.0, 293.0), 0.54 + 4.89 * std::exp(1.01), 1e-13);
  EXPECT_NEAR(failure_strain(m, 1.0 / 3, 1e4, 293.0) / 2.32103, 1 + 0.014 * std::log(1e4), 1e-5);
  EXPECT_NEAR(failure_strain(m, 1.0 / 3, 1.0, 824.5) / 2.32103, 1 + 1.12 / 2, 1e-5);
}

TEST(Failure, RateAndTemperatureCountBetweenTheirBounds) {
  const MaterialParameters m = copper();
  EXPECT_EQ(failure_strain(m, 0.0, 0.01, 293.0), failure_strain(m, 0.0, 1.0, 200.0));
  EXPECT_EQ(failure_strain(m, 0.0, 1.0, 1356.0), failure_strain(m, 0.0, 1.0, 5000.0));
}

TEST(Failure, RateCountsAsAPowerByOption) { // Weldox 460 E at 1e5/s: (1 + 2e8)^-0.0146 = 0.7564930841
  MaterialParameters m = copper();
  m.jc_d4 = -0.0146, m.rate_0 = 5e-4;
  const double slow = failure_strain(m, 0.0, 0.0, 293.0);
  EXPECT_NEAR(failure_strain(m, 0.0, 1e5, 293.0) / slow, 1 - 0.0146 * std::log(2e8), 1e-12);
  m.rate_form = RateForm::power;
  EXPECT_NEAR(failure_strain(m, 0.0, 1e5, 293.0) / slow, 0.7564930841, 1e-10);
}

TEST(Failure, TakesItsShareOfTheStrengthUpToFailure) {
  MaterialParameters m = copper();
  m.failure_softening = 0.3;
  EXPECT_EQ(weakening(m, 0.0), 1);
  EXPECT_EQ(weakening(m, 0.5), 0.85);
  EXPECT_EQ(weakening(m, 1.0), weakening(m, 7.0));
  EXPECT_EQ(weakening(m, 1.0), 0.7);
}

TEST(Failure, StrainIsPositiveAndANumberAtAnyStress) {
  MaterialParameters m = copper();
  m.jc_d1 = -0.068; // of 7075 aluminium
  for (const double triaxiality : {-1e6, -3.0, 0.0, 3.0, 1e6}) {
    EXPECT_GE(failure_strain(m, triaxiality, 1.0, 293.0), least_failure_strain);
    EXPECT_TRUE(std::isfinite(failure_strain(m, triaxiality, 1.0, 293.0)));
  }
  EXPECT_EQ(failure_strain(m, 3.0, 1.0, 293.0), least_failure_strain);
}

TEST(Failure, LanesAreAsSingleNumbers) {
  const MaterialParameters m = copper();
  Batch triaxiality = 0.5, rate = 10.0, theta = 400.0;
  triaxiality.set(1, -0.7), rate.set(1, 0.1), theta.set(1, 250.0), theta.set(2, 2000.0);
  const Batch strain = failure_strain(m, triaxiality, rate, theta);
  for (int l = 0; l < lanes; ++l)
    EXPECT_NEAR(strain[l], failure_strain(m, triaxiality[l], rate[l], theta[l]), 1e-13 * strain[l]);
}
