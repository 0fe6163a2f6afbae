#include <gtest/gtest.h>
#include <impact/material/toughness.hpp>

using namespace impact;

namespace {

ToughnessFatigue rule(FatigueLaw law) {
  return {.law = law, .threshold = 50, .kappa = 0.4, .mean_load = 0, .width = 0.01};
}

} // namespace

TEST(Toughness, StaysUpToTheThresholdAndFallsByItsFunctionBeyond) {
  const ToughnessFatigue asymptotic = rule(FatigueLaw::asymptotic),
                         logarithmic = rule(FatigueLaw::logarithmic);
  for (const ToughnessFatigue& law : {asymptotic, logarithmic}) {
    EXPECT_EQ(law.left(0.0), 1);
    EXPECT_EQ(law.left(0.5), 1); // gamma alpha_T
    EXPECT_NEAR(law.left(0.5 + 1e-9), 1, 1e-8);
    for (double x = 1; x < 1e4; x *= 1.3) EXPECT_LE(law.left(0.65 * x), law.left(0.5 * x));
  }
  EXPECT_NEAR(asymptotic.left(1.5), 0.25, 1e-15);  // 2/(1 + 3)
  EXPECT_NEAR(logarithmic.left(5.0), 0.36, 1e-15); // 1 - 0.4
  EXPECT_EQ(logarithmic.left(0.5 * 316.3), 1e-6);  // 10^(1/0.4) = 316.2
  EXPECT_GT(logarithmic.left(0.5 * 280.0), 1e-6);
  EXPECT_EQ(rule(FatigueLaw::power).left(1e9), 1);
}

TEST(Toughness, LanesAreWhatASinglePointIs) {
  for (const FatigueLaw kind : {FatigueLaw::asymptotic, FatigueLaw::logarithmic}) {
    Batch fatigue = 0;
    for (int l = 0; l < lanes; ++l) fatigue.set(l, 0.3 * (l + 1) * (l + 1));
    const Batch left = rule(kind).left(fatigue);
    for (int l = 0; l < lanes; ++l) EXPECT_NEAR(left[l], rule(kind).left(fatigue[l]), 1e-15);
  }
}

TEST(Toughness, TheSummedEnergyGrowsWhileTheEnergyDoes) {
  ToughnessFatigue law = rule(FatigueLaw::asymptotic);
  EXPECT_NEAR(law.growth(3.0, 7.0), 0.04, 1e-15);
  EXPECT_EQ(law.growth(7.0, 3.0), 0);
  law.mean_load = 20; // (49 - 9)/40
  EXPECT_NEAR(law.growth(3.0, 7.0), 0.01, 1e-15);
  EXPECT_EQ(law.growth(7.0, 3.0), 0);
}
