#include <gtest/gtest.h>
#include <impact/material/cohesive.hpp>
#include <impact/material/place_factors.hpp>
#include <set>

using namespace impact;

TEST(PlaceFactors, TheLawIsThatOfTheNumbersOfThePlace) {
  for (const Split split : {Split::volumetric, Split::spectral}) {
    MaterialParameters m;
    m.K = 20, m.G = 12, m.Gc = 0.3, m.gamma = 0.1;
    m.damage = Damage::wu, m.ge = Degradation::linear, m.split = split;
    const double strength = 0.7;
    m.cohesive = cohesive_shape(m, 1);
    m.cohesive.a1 = cohesive_slope(m, strength);
    const MaterialParameters local = law_at(PointLaw{m}, {.E = 0.6, .Gc = 1.7, .strength = 0.8}).parameters;
    m.K *= 0.6, m.G *= 0.6, m.Gc *= 1.7;
    EXPECT_EQ(local.K, m.K);
    EXPECT_EQ(local.G, m.G);
    EXPECT_EQ(local.Gc, m.Gc);
    EXPECT_NEAR(local.cohesive.a1, cohesive_slope(m, 0.8 * strength), 1e-13 * local.cohesive.a1);
  }
}

TEST(PlaceFactors, ThreeDigitsAreKept) {
  EXPECT_EQ(to_three_digits(0.25), 0.25);
  EXPECT_EQ(to_three_digits(1), 1);
  EXPECT_EQ(to_three_digits(1.0 / 3), 0.333);
  EXPECT_EQ(to_three_digits(0.99951), 1);
  EXPECT_EQ(to_three_digits(12.345), 12.3);
}

TEST(PlaceFactors, ChanceIsAFunctionOfSeedNumberAndPlace) {
  const double here[3] = {0.3, -0.1, 0}, zero[3] = {0.3, -0.1, -0.0}, there[3] = {0.3, -0.1, 1e-300};
  const auto at = [](std::uint64_t seed, std::uint64_t stream, const double* x, double length) {
    return weibull_at(seed, stream, x, length, 5);
  };
  EXPECT_EQ(at(1, 0, here, 0), at(1, 0, zero, 0));
  const std::set<double> others{at(1, 0, here, 0), at(2, 0, here, 0), at(1, 1, here, 0), at(1, 0, there, 0)};
  EXPECT_EQ(others.size(), 4u);
  EXPECT_EQ(at(1, 0, here, 0.5), at(1, 0, there, 0.5)); // one cube
  const double left[3] = {-0.01, 0, 0}, right[3] = {0.01, 0, 0};
  EXPECT_NE(at(1, 0, left, 0.5), at(1, 0, right, 0.5)); // a corner of cubes is the origin
}
