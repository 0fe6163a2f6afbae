#include <cmath>
#include <gtest/gtest.h>
#include <impact/math/batch.hpp>
#include <limits>
#include <random>

using namespace impact;

namespace {

Batch ramp(double start, double step) {
  Batch b;
  for (int l = 0; l < lanes; ++l) b.set(l, start + step * l);
  return b;
}

} // namespace

TEST(Batch, ArithmeticAndChoiceActOnEachLane) {
  const Batch a = ramp(1, 1), b = 2.0;
  for (int l = 0; l < lanes; ++l) {
    const double x = 1 + l;
    EXPECT_EQ((a + b)[l], x + 2);
    EXPECT_EQ((a - b)[l], x - 2);
    EXPECT_EQ((a * b)[l], x * 2);
    EXPECT_EQ((a / b)[l], x / 2);
    EXPECT_EQ((-a)[l], -x);
    EXPECT_EQ(sqrt(a)[l], std::sqrt(x));
    EXPECT_EQ(log(a)[l], std::log(x));
    EXPECT_EQ(select(a > b, a, Batch(-1.0))[l], x > 2 ? x : -1);
    EXPECT_EQ(max(a, b)[l], std::fmax(x, 2));
    EXPECT_EQ(min(a, b)[l], std::fmin(x, 2));
    EXPECT_EQ(abs(b - a)[l], std::fabs(2 - x));
  }
  EXPECT_EQ(bits(a > b), ((1 << lanes) - 1) & ~3);
  EXPECT_TRUE(any(a <= b));
  EXPECT_FALSE(all(a <= b));
  EXPECT_TRUE(all(a >= Batch(1.0)));
}

TEST(Batch, SelectKeepsAnUnusedNaNOut) {
  const Batch nan = std::numeric_limits<double>::quiet_NaN(), a = 3.0;
  EXPECT_EQ(select(a > Batch(2.0), a, nan)[0], 3);
  EXPECT_EQ(bits(is_finite(nan)), 0);
  EXPECT_EQ(bits(is_finite(Batch(std::numeric_limits<double>::infinity()))), 0);
  EXPECT_TRUE(all(is_finite(a)));
  EXPECT_FALSE(any(nan > a) || any(nan <= a));
}

TEST(Batch, LoadAndStoreNeedNoAlignment) {
  double memory[2 * lanes + 1];
  for (int i = 0; i < 2 * lanes + 1; ++i) memory[i] = i;
  const Batch b = load(memory + 1);
  for (int l = 0; l < lanes; ++l) EXPECT_EQ(b[l], l + 1);
  store(memory + 2, b + Batch(10.0));
  EXPECT_EQ(memory[2], 11);
  EXPECT_EQ(memory[1 + lanes], 10 + lanes);
}

TEST(Batch, ExponentialIsThatOfTheLibraryToTheLastBit) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> range(-700, 700);
  for (int i = 0; i < 50000; ++i) {
    const double x = i % 2 ? range(random) : range(random) / 1000;
    const double exact = double(std::exp((long double)x));
    EXPECT_NEAR(exp(Batch(x))[i % lanes], exact, 4e-16 * exact);
  }
  EXPECT_EQ(exp(Batch(0.0))[0], 1);
  EXPECT_TRUE(std::isnan(exp(Batch(std::nan("")))[0]));
  EXPECT_GT(exp(Batch(-1e6))[0], 0);
  EXPECT_LT(exp(Batch(-1e6))[0], 1e-300);
}

TEST(Batch, InverseCubeRootIsThatOfTheLibraryToTheLastBit) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> range(-60, 60);
  for (int i = 0; i < 50000; ++i) {
    const double x = std::exp(i % 2 ? range(random) : range(random) / 1000);
    const double exact = double(1 / std::cbrt((long double)x));
    EXPECT_NEAR(inverse_cbrt(Batch(x))[i % lanes], exact, 4e-16 * exact);
  }
  EXPECT_TRUE(std::isnan(inverse_cbrt(Batch(-1.0))[0]));
  EXPECT_TRUE(std::isnan(inverse_cbrt(Batch(0.0))[0]));
}
