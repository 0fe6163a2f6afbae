#include <gtest/gtest.h>
#include <impact/math/dual.hpp>
#include <impact/math/scalar_root.hpp>

namespace impact {

namespace {

/// Something with every operation in it.
template <class T> T mixture(const T& x, const T& y) {
  const T a = x * y + 2.0 * x - y / x, b = sqrt(a * a + T(1.0)) + exp(T(-0.3) * y);
  return log(b) * inverse_cbrt(x + b) - select(value(x) > Value<T>(0.5), x, y) * (-a) * 0.25;
}

} // namespace

TEST(Dual, DerivativesAreThoseOfTheComplexStep) {
  using Complex = std::complex<double>;
  for (double x : {0.3, 0.7, 1.9})
    for (double y : {-0.4, 0.6}) {
      const auto d = mixture(seed<double, 2>(x, 0), seed<double, 2>(y, 1));
      const Complex dx = mixture(Complex(x, 1e-30), Complex(y)), dy = mixture(Complex(x), Complex(y, 1e-30));
      EXPECT_NEAR(d.v, mixture(x, y), 1e-14);
      EXPECT_NEAR(d.d[0], dx.imag() / 1e-30, 1e-13);
      EXPECT_NEAR(d.d[1], dy.imag() / 1e-30, 1e-13);
      const auto lanes_of = mixture(seed<Batch, 2>(Batch(x), 0), seed<Batch, 2>(Batch(y), 1));
      for (int l = 0; l < lanes; ++l) EXPECT_NEAR(lanes_of.d[0][l], d.d[0], 1e-13);
    }
}

TEST(ScalarRoot, CarriesTheDerivativeOfTheRoot) { // x^3 + x = p: dx/dp = 1/(3x^2 + 1)
  using D = Dual<double, 1>;
  const double p = 3.7;
  const auto f = [&](double x, double& slope) {
    slope = -(3 * x * x + 1);
    return p - x * x * x - x;
  };
  const auto root = scalar_root(0.1, 0.0, 10.0, true, 1e-12, f);
  EXPECT_EQ(root.failed, 0);
  double slope;
  f(root.x, slope);
  const D x =
      differentiated_root(root.x, seed<double, 1>(p, 0) - D(root.x * root.x * root.x + root.x), slope);
  EXPECT_NEAR(x.v * x.v * x.v + x.v, p, 1e-14);
  EXPECT_NEAR(x.d[0], 1 / (3 * x.v * x.v + 1), 1e-14);
}

TEST(ScalarRoot, BisectsWhereNewtonLeavesTheBracket) { // -atan: Newton from 10 diverges
  const auto f = [](const Batch& x, Batch& slope) {
    Batch r;
    for (int l = 0; l < lanes; ++l) {
      const double y = x[l] - 0.5 - l;
      r.set(l, -std::atan(y));
      slope.set(l, -1 / (1 + y * y));
    }
    return r;
  };
  const Batch start = 10.0;
  const auto root = scalar_root(start, Batch(-100.0), Batch(100.0), start < Batch(11.0), 1e-12, f);
  EXPECT_EQ(root.failed, 0);
  for (int l = 0; l < lanes; ++l) EXPECT_NEAR(root.x[l], 0.5 + l, 1e-12);
}

TEST(ScalarRoot, LeavesInactiveLanesAlone) {
  const auto f = [](const Batch& x, Batch& slope) {
    slope = -1.0;
    return Batch(2.0) - x;
  };
  Batch choice = 0.0;
  choice.set(0, 1);
  const auto root = scalar_root(Batch(7.0), Batch(0.0), Batch(10.0), choice > Batch(0.5), 1e-12, f);
  EXPECT_EQ(root.x[0], 2);
  EXPECT_EQ(root.x[1], 7);
}

} // namespace impact
