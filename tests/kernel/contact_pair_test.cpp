#include <gtest/gtest.h>
#include <impact/kernel/contact_pair.hpp>
#include <limits>
#include <numbers>
#include <vector>

using namespace impact;

namespace {

using Complex = std::complex<double>;
using Dofs = std::array<double, 8>; // secondary node 0, 1, primary node 0, 1

template <class T> struct Pair {
  Point2<T> point;
  PrimaryEdge<T> edge;
};

constexpr std::array<double, 2> N = {0.7, 0.3};

// Neighbours of the edge: `previous` and `next` stand still, they only decide signs.
template <class T> Pair<T> pair_of(const std::array<T, 8>& x, Point2<double> previous, Point2<double> next) {
  Pair<T> pair;
  pair.point = {N[0] * x[0] + N[1] * x[2], N[0] * x[1] + N[1] * x[3]};
  pair.edge = {
      {x[4], x[5]}, {x[6], x[7]}, true, true, {T(previous[0]), T(previous[1])}, {T(next[0]), T(next[1])}};
  return pair;
}

struct Case {
  const char* name;
  Dofs x;
  Point2<double> previous, next;
  FootPart part;
  int sign;
};

// The primary edge runs from (-0.5, 0.02) to (0.6, -0.04): its outward normal points down.
const std::vector<Case> cases = {
    {"open", {0.1, -0.3, 0.5, -0.2, -0.5, 0.02, 0.6, -0.04}, {-1, 0.3}, {1, 0.3}, FootPart::edge, 1},
    {"inside", {0.1, 0.1, 0.5, 0.2, -0.5, 0.02, 0.6, -0.04}, {-1, 0.3}, {1, 0.3}, FootPart::edge, -1},
    {"convex first",
     {-0.8, -0.2, -0.6, -0.3, -0.5, 0.02, 0.6, -0.04},
     {-0.6, 0.9},
     {1, 0.3},
     FootPart::first_vertex,
     1},
    {"convex second",
     {0.8, -0.2, 0.9, -0.3, -0.5, 0.02, 0.6, -0.04},
     {-1, 0.3},
     {0.7, 0.9},
     FootPart::second_vertex,
     1},
    {"concave second",
     {0.9, 0.5, 0.9, 0.6, -0.5, 0.02, 0.6, -0.04},
     {-1, 0.3},
     {0.7, -0.9},
     FootPart::second_vertex,
     -1},
};

double gap_at(const Case& c, Dofs x) {
  const auto pair = pair_of<double>(x, c.previous, c.next);
  return closest_point(pair.point, pair.edge).gap;
}

Point2<double> turned(Point2<double> x, double angle) {
  return {std::cos(angle) * x[0] - std::sin(angle) * x[1] + 3,
          std::sin(angle) * x[0] + std::cos(angle) * x[1] - 7};
}

// Closed, open, closing and opening steps, and steps that touch exactly.
TEST(SecantPressure, DoesTheWorkOfThePenaltysPotential) {
  const double eps = 3e4;
  for (double g0 : {-2e-3, -1e-5, 0.0, 4e-4, 1e-2})
    for (double g1 : {-3e-3, -2e-3, -1e-5, 0.0, 4e-4, 2e-2}) {
      const double work = -secant_pressure(eps, g0, g1).p * (g1 - g0);
      const double stored = contact_potential(0, eps, g1) - contact_potential(0, eps, g0);
      EXPECT_NEAR(work, stored, 1e-15 * eps * (g0 * g0 + g1 * g1)) << g0 << " to " << g1;
      EXPECT_GE(secant_pressure(eps, g0, g1).p, 0);
    }
  EXPECT_DOUBLE_EQ(secant_pressure(eps, -2e-3, -2e-3).p, contact_pressure(0, eps, -2e-3));
}

TEST(SecantPressure, SlopeIsTheDerivativeByTheGapOfTheEnd) {
  const double eps = 3e4, h = 1e-7;
  for (double g0 : {-2e-3, 4e-4})
    for (double g1 : {-3e-3, -1e-4, 5e-4, 2e-2}) {
      const double difference =
          (secant_pressure(eps, g0, g1 + h).p - secant_pressure(eps, g0, g1 - h).p) / (2 * h);
      EXPECT_NEAR(secant_pressure(eps, g0, g1).slope, difference, 1e-5 * eps) << g0 << " to " << g1;
    }
}

} // namespace

TEST(ContactPair, GapAndFootPointAgreeWithTheOracle) {
  PrimaryEdge<double> edge{{-0.5, 0.02}, {0.6, -0.04}};
  const auto foot = closest_point<double>({0.31, -0.07}, edge);
  EXPECT_EQ(foot.part, FootPart::edge);
  // oracle.py rows contact.gap.order1, contact.xi.order1, contact.hess00.order1. The oracle takes the same
  // normal (t_y, -t_x).
  EXPECT_NEAR(foot.gap, 0.04575017425429, 1e-13);
  EXPECT_NEAR(foot.xi, 0.4772577455504, 1e-12);
  EXPECT_NEAR(gap_hessian({1, 0}, edge, foot)[0], 0.0, 1e-15);
}

TEST(ContactPair, GradientIsTheComplexStepOfTheGap) {
  for (const Case& c : cases) {
    const auto pair = pair_of<double>(c.x, c.previous, c.next);
    const auto foot = closest_point(pair.point, pair.edge);
    ASSERT_EQ(foot.part, c.part) << c.name;
    ASSERT_EQ(foot.gap < 0 ? -1 : 1, c.sign) << c.name;
    const auto dg = gap_gradient(N, foot);
    for (std::size_t i = 0; i < 8; ++i) {
      std::array<Complex, 8> z;
      for (std::size_t j = 0; j < 8; ++j) z[j] = Complex(c.x[j], i == j ? 1e-30 : 0);
      const auto stepped = pair_of<Complex>(z, c.previous, c.next);
      EXPECT_NEAR(dg[i], closest_point(stepped.point, stepped.edge).gap.imag() / 1e-30, 1e-13)
          << c.name << " dof " << i;
    }
  }
}

TEST(ContactPair, HessianIsTheComplexStepOfTheGradientAndTheDifferenceOfTheGap) {
  for (const Case& c : cases) {
    const auto pair = pair_of<double>(c.x, c.previous, c.next);
    const auto d2g = gap_hessian(N, pair.edge, closest_point(pair.point, pair.edge));
    double largest = 0;
    for (std::size_t j = 0; j < 8; ++j) {
      std::array<Complex, 8> z;
      for (std::size_t i = 0; i < 8; ++i) z[i] = Complex(c.x[i], i == j ? 1e-30 : 0);
      const auto stepped = pair_of<Complex>(z, c.previous, c.next);
      const auto dg = gap_gradient(N, closest_point(stepped.point, stepped.edge));
      for (std::size_t i = 0; i < 8; ++i) {
        largest = std::max(largest, std::abs(d2g[8 * i + j]));
        EXPECT_NEAR(d2g[8 * i + j], dg[i].imag() / 1e-30, 1e-12) << c.name << " entry " << i << ", " << j;
        const double h = 1e-4;
        auto moved = [&](double a, double b) {
          Dofs x = c.x;
          x[i] += a * h;
          x[j] += b * h;
          return gap_at(c, x);
        };
        const double difference = (moved(1, 1) - moved(1, -1) - moved(-1, 1) + moved(-1, -1)) / (4 * h * h);
        EXPECT_NEAR(d2g[8 * i + j], difference, 1e-5) << c.name << " entry " << i << ", " << j;
      }
    }
    EXPECT_GT(largest, 0.1) << c.name;
  }
}

TEST(ContactPair, GapAndForceDoNotChangeWhenTheWholePairIsTurned) {
  for (const Case& c : cases) {
    const auto rest = pair_of<double>(c.x, c.previous, c.next);
    const auto foot = closest_point(rest.point, rest.edge);
    for (int degrees = 0; degrees <= 360; ++degrees) {
      const double angle = degrees * std::numbers::pi / 180;
      PrimaryEdge<double> edge{turned(rest.edge.x0, angle),       turned(rest.edge.x1, angle),  true, true,
                               turned(rest.edge.previous, angle), turned(rest.edge.next, angle)};
      const auto other = closest_point(turned(rest.point, angle), edge);
      ASSERT_EQ(other.part, foot.part) << c.name << " at " << degrees;
      ASSERT_NEAR(other.gap, foot.gap, 1e-12) << c.name << " at " << degrees;
      ASSERT_NEAR(other.xi, foot.xi, 1e-12) << c.name << " at " << degrees;
      const Point2<double> n = {std::cos(angle) * foot.normal[0] - std::sin(angle) * foot.normal[1],
                                std::sin(angle) * foot.normal[0] + std::cos(angle) * foot.normal[1]};
      ASSERT_NEAR(detail::dot(other.normal, n), 1.0, 1e-12) << c.name << " at " << degrees;
    }
  }
}

TEST(ContactPair, ForceIsTheDerivativeOfThePotential) {
  const double eps = 3e3;
  for (double lambda : {0.0, 40.0})
    for (double gap : {-0.02, -1e-3, 5e-3, 0.05}) {
      const double step = 1e-7;
      const double slope =
          (contact_potential(lambda, eps, gap + step) - contact_potential(lambda, eps, gap - step)) /
          (2 * step);
      EXPECT_NEAR(-contact_pressure(lambda, eps, gap), slope, 1e-4) << lambda << " " << gap;
    }
  EXPECT_DOUBLE_EQ(contact_pressure(40, eps, -0.02), 100);
  EXPECT_DOUBLE_EQ(contact_pressure(0, eps, 0.02), 0);
}

TEST(ContactPair, TangentIsTheDifferenceOfTheForce) {
  const double eps = 50, lambda = 60, weight = 0.8;
  for (const Case& c : cases) {
    auto force = [&](const Dofs& x) {
      const auto pair = pair_of<double>(x, c.previous, c.next);
      const auto foot = closest_point(pair.point, pair.edge);
      auto f = gap_gradient(N, foot);
      for (double& entry : f) entry *= -weight * contact_pressure(lambda, eps, foot.gap);
      return f;
    };
    const auto pair = pair_of<double>(c.x, c.previous, c.next);
    const auto foot = closest_point(pair.point, pair.edge);
    const double p = contact_pressure(lambda, eps, foot.gap);
    ASSERT_GT(p, 0);
    // K = weight (eps dg dg - p d2g)
    const auto dg = gap_gradient(N, foot);
    std::array<double, 64> K = gap_hessian(N, pair.edge, foot);
    for (std::size_t i = 0; i < 64; ++i) K[i] = weight * (eps * dg[i / 8] * dg[i % 8] - p * K[i]);
    for (std::size_t j = 0; j < 8; ++j) {
      Dofs up = c.x, down = c.x;
      up[j] += 1e-6;
      down[j] -= 1e-6;
      const auto f_up = force(up), f_down = force(down);
      for (std::size_t i = 0; i < 8; ++i) {
        EXPECT_NEAR(K[8 * i + j], (f_up[i] - f_down[i]) / 2e-6, 2e-6) << c.name << " " << i << ", " << j;
        EXPECT_NEAR(K[8 * i + j], K[8 * j + i], 1e-12);
      }
    }
  }
}

TEST(ContactPair, DistanceIsContinuousAlongAChainOfEdges) {
  // A convex and a concave corner; the point walks past them at constant height over the chain and below it.
  const std::vector<Point2<double>> chain = {{2, 0}, {1, 0.3}, {0, 0}, {-1, 0.5}, {-2, 0.5}};
  for (double offset : {0.05, -0.05}) {
    double before = 0;
    for (int step = 0; step <= 3000; ++step) {
      const Point2<double> x = {1.5 - step * 1e-3, 0.15 + offset};
      double best = 1e9;
      for (std::size_t e = 0; e + 1 < chain.size(); ++e) {
        PrimaryEdge<double> edge{chain[e], chain[e + 1], e > 0, e + 2 < chain.size()};
        if (edge.has_previous) edge.previous = chain[e - 1];
        if (edge.has_next) edge.next = chain[e + 2];
        const auto foot = closest_point(x, edge);
        if (foot.part != FootPart::none && std::abs(foot.gap) < std::abs(best)) best = foot.gap;
      }
      if (step > 0) {
        ASSERT_NEAR(best, before, 1.01e-3) << "step " << step;
      }
      before = best;
    }
  }
}

TEST(ContactPair, NearestEdgeDecidesForEveryAngleBetweenTheFacets) {
  // A point in the face of a primary, its own facet inclined by 0 to 90 degrees: always accepted, always the
  // same gap.
  PrimaryEdge<double> edge{{1, 0}, {-1, 0}};
  for (int degrees = 0; degrees <= 90; ++degrees) {
    const double angle = degrees * std::numbers::pi / 180;
    const Point2<double> normal = {std::sin(angle), -std::cos(angle)};
    for (double height : {-0.01, 0.01}) {
      const auto foot = closest_point<double>({0.2, height}, edge);
      EXPECT_NEAR(foot.gap, height, 1e-15);
      const double rank = retraction(foot, normal, 0.5);
      EXPECT_GE(rank, 0.01 * (1 - 1e-12)) << degrees;
      EXPECT_LE(rank, 10.0 * (1 + 1e-12)) << degrees;
      if (degrees <= 60) {
        EXPECT_NEAR(rank, 0.01, 1e-12) << degrees;
      }
    }
  }
}

TEST(ContactPair, DeepPointLeavesThroughTheFaceItCameBy) {
  // A point 0.3 below the top of a body and only 0.1 from its side, with a facet that looks down.
  PrimaryEdge<double> top{{1, 0}, {-1, 0}, true, true, {1, -1}, {-1, -1}},
      side{{1, -1}, {1, 0}, true, true, {-1, -1}, {-1, 0}};
  const Point2<double> x = {0.9, -0.3}, down = {0, -1};
  const auto through_top = closest_point(x, top), through_side = closest_point(x, side);
  EXPECT_NEAR(through_top.gap, -0.3, 1e-15);
  EXPECT_NEAR(through_side.gap, -0.1, 1e-15);
  EXPECT_LT(retraction(through_top, down, 0.5), retraction(through_side, down, 0.5));
  EXPECT_EQ(retraction(through_top, down, 0.2), std::numeric_limits<double>::infinity());
  // The back of a thin body looks the same way as the point and is never met.
  PrimaryEdge<double> back{{-1, -0.31}, {1, -0.31}};
  EXPECT_EQ(retraction(closest_point(x, back), down, 0.5), std::numeric_limits<double>::infinity());
}

TEST(ContactPair, PointBesideAnEdgeBelongsToTheNeighbourThatItProjectsOnto) {
  // The second edge continues the first; without the neighbour's claim the first would report its vertex,
  // sideways.
  PrimaryEdge<double> edge{{1, 0}, {0, 0}, true, true, {2, 0.1}, {-1, 0.1}};
  EXPECT_EQ(closest_point<double>({-0.5, -0.05}, edge).part, FootPart::none);
  EXPECT_EQ(closest_point<double>({1.5, -0.05}, edge).part, FootPart::none);
  EXPECT_EQ(closest_point<double>({-0.02, -1}, edge).part, FootPart::second_vertex);
}

TEST(ContactPair, ContactEndsAtTheEndOfAnOpenSurface) {
  PrimaryEdge<double> edge{{1, 0}, {-1, 0}};
  EXPECT_EQ(closest_point<double>({1.01, -0.1}, edge).part, FootPart::edge);
  EXPECT_EQ(closest_point<double>({1.03, -0.1}, edge).part, FootPart::none);
  EXPECT_EQ(closest_point<double>({-1.03, -0.1}, edge).part, FootPart::none);
}

TEST(ContactPair, UzawaOnOneSpringReproducesTheOracle) {
  // oracle.py O13: a spring k pushed by f on a wall at distance g0.
  const double k = 1e9, f = 5e3, g0 = 1e-6, eps = 4e9;
  const std::array<double, 5> gaps = {-8e-07, -1.6e-07, -3.2e-08, -6.4e-09, -1.28e-09};
  double lambda = 0;
  for (double expected : gaps) {
    const double u = (f - lambda + eps * g0) / (k + eps); // k u = f - <lambda - eps (g0 - u)>
    EXPECT_NEAR(g0 - u, expected, 1e-10 * 8e-07);
    EXPECT_NEAR(k * u, f - contact_pressure(lambda, eps, g0 - u), 1e-9 * f);
    lambda = contact_pressure(lambda, eps, g0 - u);
  }
  EXPECT_NEAR(lambda, 4000, 4000 * 0.2 * 0.2 * 0.2 * 0.2 * 0.2 * 1.0001);
}
