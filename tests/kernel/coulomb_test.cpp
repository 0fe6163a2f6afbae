#include <gtest/gtest.h>
#include <impact/kernel/coulomb.hpp>
#include <random>

using namespace impact;

TEST(Coulomb, SticksBelowTheLimitAndSlidesWithIt) {
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

TEST(Coulomb, AStepOfExactWorkNeverGivesBackMoreThanItsSpringHeld) {
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
