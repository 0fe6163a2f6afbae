#include <complex>
#include <gtest/gtest.h>
#include <impact/kernel/contact_slip.hpp>
#include <random>

using namespace impact;

namespace {

using Edge = std::array<Point2<double>, 2>;
using Complex = std::complex<double>;

struct Pair {
  Edge x, p;
  SlipAnchor anchor;
  double& dof(int i) {
    Edge& e = i < 4 ? x : p;
    return e[static_cast<std::size_t>(i % 4 / 2)][static_cast<std::size_t>(i % 2)];
  }
};

Pair random_pair(std::mt19937& random) {
  std::uniform_real_distribution<double> u(-1, 1);
  Pair pair;
  pair.x = {{{0.2 * u(random), 0.2 * u(random)}, {1 + 0.2 * u(random), 0.2 * u(random)}}};
  pair.p = {{{1 + 0.3 * u(random), 0.2 * u(random)}, {0.3 * u(random), 0.2 * u(random)}}};
  const double c = 0.5 + 0.4 * u(random), m = 0.5 + 0.4 * u(random);
  pair.anchor = {{0.7 * (1 - c), 0.7 * c}, {0.7 * (1 - m), 0.7 * m}};
  return pair;
}

// s = t.v by its definition, in complex numbers.
Complex slip_by_definition(Pair pair, int perturbed) {
  std::array<std::array<Complex, 2>, 4> y;
  for (int i = 0; i < 8; ++i)
    y[static_cast<std::size_t>(i / 2)][static_cast<std::size_t>(i % 2)] = pair.dof(i);
  if (perturbed >= 0)
    y[static_cast<std::size_t>(perturbed / 2)][static_cast<std::size_t>(perturbed % 2)] += Complex(0, 1e-30);
  Complex square = 0, along = 0;
  for (std::size_t k = 0; k < 2; ++k) {
    const Complex e = y[1][k] - y[0][k];
    const Complex v = pair.anchor.c[0] * y[0][k] + pair.anchor.c[1] * y[1][k] - pair.anchor.m[0] * y[2][k] -
                      pair.anchor.m[1] * y[3][k];
    square += e * e;
    along += e * v;
  }
  return along / std::sqrt(square);
}

} // namespace

TEST(ContactSlip, GradientIsTheComplexStepOfTheSlip) {
  std::mt19937 random(1);
  for (int i = 0; i < 50; ++i) {
    Pair pair = random_pair(random);
    const Slip slip = slip_of(pair.x, pair.p, pair.anchor);
    EXPECT_NEAR(slip.value, slip_by_definition(pair, -1).real(), 1e-14);
    for (int j = 0; j < 8; ++j)
      EXPECT_NEAR(slip.gradient[static_cast<std::size_t>(j)], slip_by_definition(pair, j).imag() / 1e-30,
                  1e-13);
  }
}

TEST(ContactSlip, HessianIsTheDerivativeOfTheGradient) {
  std::mt19937 random(2);
  for (int i = 0; i < 50; ++i) {
    Pair pair = random_pair(random);
    const auto H = slip_hessian(pair.x, pair.p, pair.anchor);
    for (int j = 0; j < 8; ++j) {
      constexpr double h = 1e-5;
      Pair up = pair, down = pair;
      up.dof(j) += h;
      down.dof(j) -= h;
      const Slip above = slip_of(up.x, up.p, up.anchor), below = slip_of(down.x, down.p, down.anchor);
      for (std::size_t k = 0; k < 8; ++k)
        EXPECT_NEAR(H[8 * static_cast<std::size_t>(j) + k], (above.gradient[k] - below.gradient[k]) / (2 * h),
                    1e-8);
    }
  }
}

TEST(ContactSlip, RigidMotionsDoNotSlipAndForcesBalance) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(-3, 3);
  for (int i = 0; i < 50; ++i) {
    Pair pair = random_pair(random), moved = pair;
    const double angle = u(random), c = std::cos(angle), s = std::sin(angle), dx = u(random), dy = u(random);
    for (int node = 0; node < 4; ++node) {
      const double x = pair.dof(2 * node), y = pair.dof(2 * node + 1);
      moved.dof(2 * node) = c * x - s * y + dx;
      moved.dof(2 * node + 1) = s * x + c * y + dy;
    }
    const Slip slip = slip_of(moved.x, moved.p, moved.anchor);
    EXPECT_NEAR(slip.value, slip_of(pair.x, pair.p, pair.anchor).value, 1e-13);
    double force[2] = {0, 0}, moment = 0;
    for (int node = 0; node < 4; ++node) {
      const double fx = slip.gradient[static_cast<std::size_t>(2 * node)],
                   fy = slip.gradient[static_cast<std::size_t>(2 * node + 1)];
      force[0] += fx;
      force[1] += fy;
      moment += moved.dof(2 * node) * fy - moved.dof(2 * node + 1) * fx;
    }
    EXPECT_NEAR(std::abs(force[0]) + std::abs(force[1]), 0, 1e-14);
    EXPECT_NEAR(moment, 0, 1e-13);
  }
}

TEST(ContactSlip, CoulombSticksBelowTheLimitAndSlidesWithIt) {
  EXPECT_EQ(coulomb({0.5, 0}, 1).value[0], 0.5);
  EXPECT_FALSE(coulomb({0.5, 0}, 1).slides);
  EXPECT_EQ(coulomb({-3, 0}, 1).value[0], -1);
  EXPECT_EQ(coulomb({-3, 0}, 1).direction[0], -1);
  EXPECT_FALSE(coulomb({0, 0}, 0).slides);
  const Traction oblique = coulomb({-3, 4}, 0.5);
  EXPECT_DOUBLE_EQ(oblique.value[0], -0.3);
  EXPECT_DOUBLE_EQ(oblique.value[1], 0.4);
  EXPECT_DOUBLE_EQ(oblique.excess, 4.5);
  EXPECT_FALSE(coulomb({-0.3, 0.4}, 0.51).slides);
}
