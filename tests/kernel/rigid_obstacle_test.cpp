#include <cmath>
#include <gtest/gtest.h>
#include <impact/kernel/rigid_obstacle.hpp>
#include <random>

using namespace impact;

namespace {

std::array<RigidObstacle, 3> obstacles() {
  const double s = 1 / std::sqrt(14.0);
  const std::array<double, 3> direction = {s, -2 * s, 3 * s}, point = {0.3, 0.1, -0.2};
  return {{{RigidObstacle::Shape::plane, point, direction, 0},
           {RigidObstacle::Shape::sphere, point, direction, 0.7},
           {RigidObstacle::Shape::cylinder, point, direction, 0.7}}};
}

} // namespace

TEST(RigidObstacle, GapsAreTheDistancesOfTheShapes) {
  const std::array<double, 3> x = {1, 2, 3};
  const auto all = obstacles();
  const double s = 1 / std::sqrt(14.0);
  const double along = s * (0.7 - 2 * 1.9 + 3 * 3.2), square = 0.7 * 0.7 + 1.9 * 1.9 + 3.2 * 3.2;
  EXPECT_NEAR(gap_to(all[0], x).gap, along, 1e-14);
  EXPECT_NEAR(gap_to(all[1], x).gap, std::sqrt(square) - 0.7, 1e-14);
  EXPECT_NEAR(gap_to(all[2], x).gap, std::sqrt(square - along * along) - 0.7, 1e-14);
}

TEST(RigidObstacle, NormalAndCurvatureAreTheDerivativesOfTheGap) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> u(-2, 2);
  constexpr double h = 1e-6;
  for (const RigidObstacle& obstacle : obstacles())
    for (int trial = 0; trial < 20; ++trial) {
      const std::array<double, 3> x = {u(random), u(random), u(random)};
      const ObstacleGap at = gap_to(obstacle, x);
      for (std::size_t k = 0; k < 3; ++k) {
        std::array<double, 3> up = x, down = x;
        up[k] += h;
        down[k] -= h;
        const ObstacleGap right = gap_to(obstacle, up), left = gap_to(obstacle, down);
        EXPECT_NEAR(at.normal[k], (right.gap - left.gap) / (2 * h), 1e-8);
        for (std::size_t j = 0; j < 3; ++j)
          EXPECT_NEAR(at.curvature[3 * j + k], (right.normal[j] - left.normal[j]) / (2 * h), 1e-7);
      }
    }
}

TEST(RigidObstacle, TheMiddleOfARoundOneHasAUnitNormalAcrossTheAxis) {
  for (RigidObstacle obstacle : obstacles()) {
    if (obstacle.shape == RigidObstacle::Shape::plane) continue;
    obstacle.direction = {0, 0, 1};
    const ObstacleGap middle = gap_to(obstacle, obstacle.point);
    EXPECT_EQ(middle.gap, -0.7);
    EXPECT_EQ(std::hypot(middle.normal[0], middle.normal[1]), 1);
    EXPECT_EQ(middle.normal[2], 0);
  }
}

TEST(RigidObstacle, DistancesFromThePoleAreTheSameAndKeepTheirDigits) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> u(-1, 1);
  for (RigidObstacle obstacle : obstacles()) {
    if (obstacle.shape == RigidObstacle::Shape::plane) continue;
    obstacle.direction = {0, 0, 1};
    for (double radius : {0.7, 1e5}) {
      // The pole at the origin, the bodies around it.
      obstacle.radius = radius;
      obstacle.point = {-0.6 * radius, -0.8 * radius, 0};
      RigidObstacle near = obstacle;
      near.outward = {0.6, 0.8, 0};
      double worst_far = 0;
      for (int trial = 0; trial < 50; ++trial) {
        const std::array<double, 3> x = {u(random), u(random), u(random)};
        const long double X = x[0] + 0.6L * radius, Y = x[1] + 0.8L * radius,
                          Z = obstacle.shape == RigidObstacle::Shape::sphere ? x[2] : 0;
        const auto exact =
            static_cast<double>(std::sqrt(X * X + Y * Y + Z * Z) - static_cast<long double>(radius));
        EXPECT_NEAR(gap_to(near, x).gap, exact, 2e-14);
        EXPECT_NEAR(gap_to(near, x).normal[0], static_cast<double>(X) / (radius + exact), 1e-15);
        worst_far = std::max(worst_far, std::abs(gap_to(obstacle, x).gap - exact));
      }
      if (radius > 1) {
        EXPECT_GT(worst_far, 1e-12); // what the pole is for
      }
    }
  }
}

namespace {

// The value at place q + c and direction d, both moved.
double moved_gap(RigidObstacle obstacle, const std::array<double, 3>& x, const std::array<double, 6>& by) {
  std::array<double, 3> place = x;
  for (std::size_t k = 0; k < 3; ++k) {
    place[k] += by[k];
    obstacle.direction[k] += by[3 + k];
  }
  return carried_gap(obstacle, place).value;
}

} // namespace

TEST(RigidObstacle, GapsOfCarriedOnesHaveExactDerivativesByPlaceAndDirection) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(-2, 2);
  constexpr double h = 1e-4;
  for (RigidObstacle obstacle : obstacles())
    for (const double size : {1.0, 0.9}) // between two rigid states directions are shorter
      for (int trial = 0; trial < 20; ++trial) {
        RigidObstacle now = obstacle;
        for (double& component : now.direction) component *= size;
        const std::array<double, 3> x = {u(random), u(random), u(random)};
        const CarriedFunction at = carried_gap(now, x);
        if (size == 1) {
          EXPECT_NEAR(at.value, gap_to(obstacle, x).gap, 1e-15);
        }
        // How the two take part in a motion of one node, chosen at random.
        const CarriedShare row = {u(random), u(random)}, column = {u(random), u(random)};
        const std::array<double, 3> gradient = gradient_by(at, row);
        const std::array<double, 9> hessian = hessian_by(at, row, column);
        const auto value = [&](std::size_t i, double a, std::size_t j, double b) {
          std::array<double, 6> by{};
          by[i] += a * row.place;
          by[3 + i] += a * row.direction;
          by[j] += b * column.place;
          by[3 + j] += b * column.direction;
          return moved_gap(now, x, by);
        };
        // Central differences of fourth order.
        const auto slope = [&](auto&& f) { return (8 * (f(h) - f(-h)) - (f(2 * h) - f(-2 * h))) / (12 * h); };
        for (std::size_t i = 0; i < 3; ++i) {
          EXPECT_NEAR(gradient[i], slope([&](double a) { return value(i, a, 0, 0); }), 1e-9);
          for (std::size_t j = 0; j < 3; ++j) {
            const double difference =
                slope([&](double a) { return slope([&](double b) { return value(i, a, j, b); }); });
            EXPECT_NEAR(hessian[3 * i + j], difference, 2e-6 * (1 + std::abs(difference)));
          }
        }
      }
}

TEST(RigidObstacle, TheGapToACarriedPlaneChangesByItsGradientAtTheMiddle) {
  const std::array<double, 3> q0 = {0.3, -0.2, 0.7}, q1 = {-0.1, 0.4, 0.2}, d0 = {0.6, 0.8, 0},
                              d1 = {0, 0.6, 0.8};
  std::array<double, 3> q{}, d{};
  double change = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    q[k] = (q0[k] + q1[k]) / 2;
    d[k] = (d0[k] + d1[k]) / 2;
  }
  const CarriedFunction middle = carried_product(q, d);
  for (std::size_t k = 0; k < 3; ++k)
    change += middle.by_place[k] * (q1[k] - q0[k]) + middle.by_direction[k] * (d1[k] - d0[k]);
  EXPECT_NEAR(change, carried_product(q1, d1).value - carried_product(q0, d0).value, 1e-15);
}
