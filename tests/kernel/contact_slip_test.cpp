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

TEST(ContactSlip, AStepOfExactWorkNeverGivesBackMoreThanItsSpringHeld) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> u(-1, 1);
  int slid = 0, stuck = 0;
  for (int i = 0; i < 2000; ++i) {
    const double eps = std::exp(3 * u(random)), limit = std::abs(u(random)), limit_end = std::abs(u(random));
    const Tangential held = {u(random), i % 2 == 0 ? 0 : u(random)},
                     slip = {u(random), i % 2 == 0 ? 0 : u(random)};
    const StepTraction t = step_traction(held, slip, eps, limit, limit_end);
    const auto energy = [eps](const Tangential& x) { return inner(x, x) / (2 * eps); };
    EXPECT_LE(std::sqrt(inner(t.over.value, t.over.value)), limit * (1 + 1e-14));
    EXPECT_LE(std::sqrt(inner(t.end, t.end)), limit_end * (1 + 1e-14));
    const double work = inner(t.over.value, slip);
    EXPECT_GE(t.loss, -1e-14 * (energy(held) + std::abs(work)));
    EXPECT_NEAR(work, energy(t.end) - energy(held) + t.loss, 1e-12 * (1 + 1 / eps));
    // Within both limits: a spring, whose work is all kept.
    const Tangential whole = {held[0] + eps * slip[0], held[1] + eps * slip[1]};
    if (!t.over.slides && inner(whole, whole) <= limit_end * limit_end) {
      ++stuck;
      EXPECT_EQ(t.loss, 0);
      EXPECT_NEAR(t.end[0], whole[0], 1e-14);
      EXPECT_NEAR(t.end[1], whole[1], 1e-14);
    }
    if (t.over.slides) ++slid;
  }
  EXPECT_GT(slid, 500);
  EXPECT_GT(stuck, 50);
  // Sliding on at a constant pressure: all of the work is heat.
  const StepTraction on = step_traction({-0.3, 0.4}, {-0.6, 0.8}, 2, 0.5, 0.5);
  EXPECT_TRUE(on.over.slides);
  EXPECT_NEAR(on.end[0], -0.3, 1e-15);
  EXPECT_NEAR(on.loss, 0.5, 1e-15);
}
