#include <complex>
#include <gtest/gtest.h>
#include <impact/kernel/mortar_segment.hpp>
#include <random>

using namespace impact;

namespace {

using Edge = std::array<Point2<double>, 2>;
using Complex = std::complex<double>;

struct Pair {
  Edge x, p;
  MortarEdge edge;
};

// A primary edge roughly opposite to the secondary one, shifted, turned, of another length.
Pair random_pair(std::mt19937& random, bool ring = false) {
  std::uniform_real_distribution<double> u(-1, 1);
  Pair pair;
  pair.x = {{{0.1 * u(random), 0.1 * u(random)}, {1 + 0.1 * u(random), 0.2 * u(random)}}};
  const double middle = 0.5 + 0.7 * u(random), length = 0.5 + 0.4 * u(random);
  pair.p = {{{middle + length, -0.1 + 0.1 * u(random)}, {middle - length, -0.1 + 0.1 * u(random)}}};
  pair.edge.length = 1 + 0.3 * u(random);
  if (ring) pair.edge.ring = {1.5, 2.5};
  pair.edge.phi = dual_functions(pair.edge);
  return pair;
}

double& dof(Edge& x, Edge& p, int i) {
  Edge& e = i < 4 ? x : p;
  return e[static_cast<std::size_t>(i % 4 / 2)][static_cast<std::size_t>(i % 2)];
}

// G_a by the definition: many points along the secondary edge, a ray along its normal to the primary.
std::array<double, 2> by_rays(const Pair& pair) {
  std::array<double, 2> G{};
  constexpr int n = 400000;
  const auto t = detail::minus(pair.x[1], pair.x[0]);
  const auto normal = detail::right_normal(pair.x[0], pair.x[1]);
  for (int i = 0; i < n; ++i) {
    const double s = (i + 0.5) / n;
    const Point2<double> x = {pair.x[0][0] + s * t[0], pair.x[0][1] + s * t[1]};
    // x + g n = p0 + r (p1 - p0)
    const auto q = detail::minus(pair.p[1], pair.p[0]), d = detail::minus(pair.p[0], x);
    const double det = -normal[0] * q[1] + normal[1] * q[0];
    const double g = (-d[0] * q[1] + d[1] * q[0]) / det, r = (normal[0] * d[1] - normal[1] * d[0]) / det;
    if (r < 0 || r > 1) continue;
    const double ring = pair.edge.ring[0] * (1 - s) + pair.edge.ring[1] * s;
    for (std::size_t a = 0; a < 2; ++a)
      G[a] += (pair.edge.phi[a][0] * (1 - s) + pair.edge.phi[a][1] * s) * g * ring * pair.edge.length / n;
  }
  return G;
}

} // namespace

TEST(MortarSegment, WeightedGapsAreTheIntegralsAlongTheNormal) {
  std::mt19937 random(1);
  for (int i = 0; i < 20; ++i) {
    const Pair pair = random_pair(random, i % 2 == 1);
    const MortarPair result = mortar_pair(pair.x, pair.p, pair.edge, true);
    const auto reference = by_rays(pair);
    for (std::size_t a = 0; a < 2; ++a) EXPECT_NEAR(result.gap[a], reference[a], 3e-6) << i;
  }
}

TEST(MortarSegment, GradientIsTheComplexStepOfTheGaps) {
  std::mt19937 random(2);
  int covered = 0;
  for (int i = 0; i < 50; ++i) {
    Pair pair = random_pair(random, i % 2 == 1);
    const MortarPair result = mortar_pair(pair.x, pair.p, pair.edge, true);
    covered += result.covered;
    if (!result.covered) continue;
    for (int j = 0; j < 8; ++j) {
      std::array<Point2<Complex>, 2> x, p;
      for (std::size_t node = 0; node < 2; ++node)
        for (std::size_t k = 0; k < 2; ++k) {
          x[node][k] = pair.x[node][k];
          p[node][k] = pair.p[node][k];
        }
      auto& e = j < 4 ? x : p;
      e[static_cast<std::size_t>(j % 4 / 2)][static_cast<std::size_t>(j % 2)] += Complex(0, 1e-30);
      const auto G = weighted_gaps(covered_part(x, p), pair.edge);
      for (std::size_t a = 0; a < 2; ++a)
        EXPECT_NEAR(result.gradient[a][static_cast<std::size_t>(j)], G[a].imag() / 1e-30, 1e-13);
    }
  }
  EXPECT_GT(covered, 30);
}

TEST(MortarSegment, HessianIsTheDerivativeOfTheGradient) {
  std::mt19937 random(3);
  const std::array<double, 2> factor = {0.7, -1.3};
  for (int i = 0; i < 20; ++i) {
    Pair pair = random_pair(random, i % 2 == 1);
    std::array<double, 64> H{};
    ASSERT_TRUE(add_mortar_hessian(pair.x, pair.p, pair.edge, {factor[0], factor[1]}, H));
    for (int j = 0; j < 8; ++j) {
      Edge x = pair.x, p = pair.p;
      constexpr double h = 1e-5;
      std::array<double, 8> slope{};
      for (const double side : {1.0, -1.0}) {
        Edge xs = x, ps = p;
        dof(xs, ps, j) += side * h;
        const MortarPair moved = mortar_pair(xs, ps, pair.edge, true);
        for (std::size_t k = 0; k < 8; ++k)
          slope[k] += side * (factor[0] * moved.gradient[0][k] + factor[1] * moved.gradient[1][k]) / (2 * h);
      }
      for (std::size_t k = 0; k < 8; ++k) {
        EXPECT_NEAR(H[8 * static_cast<std::size_t>(j) + k], slope[k], 1e-7);
        EXPECT_NEAR(H[8 * static_cast<std::size_t>(j) + k], H[8 * k + static_cast<std::size_t>(j)], 1e-12);
      }
    }
  }
}

TEST(MortarSegment, ForcesAndMomentsOfAPairBalance) {
  std::mt19937 random(4);
  for (int i = 0; i < 50; ++i) {
    Pair pair = random_pair(random);
    const MortarPair result = mortar_pair(pair.x, pair.p, pair.edge, true);
    for (std::size_t a = 0; a < 2; ++a) {
      double force[2] = {0, 0}, moment = 0;
      for (int node = 0; node < 4; ++node) {
        const double fx = result.gradient[a][static_cast<std::size_t>(2 * node)],
                     fy = result.gradient[a][static_cast<std::size_t>(2 * node + 1)];
        force[0] += fx;
        force[1] += fy;
        moment += dof(pair.x, pair.p, 2 * node) * fy - dof(pair.x, pair.p, 2 * node + 1) * fx;
      }
      EXPECT_NEAR(force[0], 0, 1e-14);
      EXPECT_NEAR(force[1], 0, 1e-14);
      EXPECT_NEAR(moment, 0, 1e-14);
    }
  }
}

TEST(MortarSegment, ASplitPrimaryEdgeGivesTheSameGaps) {
  std::mt19937 random(5);
  for (int i = 0; i < 50; ++i) {
    const Pair pair = random_pair(random);
    const Point2<double> middle = {0.3 * pair.p[0][0] + 0.7 * pair.p[1][0],
                                   0.3 * pair.p[0][1] + 0.7 * pair.p[1][1]};
    const MortarPair whole = mortar_pair(pair.x, pair.p, pair.edge, true),
                     first = mortar_pair(pair.x, {pair.p[0], middle}, pair.edge, true),
                     second = mortar_pair(pair.x, {middle, pair.p[1]}, pair.edge, true);
    for (std::size_t a = 0; a < 2; ++a) EXPECT_NEAR(whole.gap[a], first.gap[a] + second.gap[a], 1e-14);
  }
}

TEST(MortarSegment, DualFunctionsAreBiorthogonalAndWeightsHaveTheSameRowSums) {
  std::mt19937 random(6);
  for (int i = 0; i < 20; ++i) {
    Pair pair = random_pair(random, i % 2 == 1);
    const MortarWeights w = mortar_weights(pair.x, pair.p, pair.edge);
    for (std::size_t a = 0; a < 2; ++a) EXPECT_NEAR(w.D[a][0] + w.D[a][1], w.M[a][0] + w.M[a][1], 1e-14);
    // A primary edge that covers the whole secondary one.
    const auto t = detail::minus(pair.x[1], pair.x[0]);
    const Edge all = {
        {{pair.x[1][0] + t[0], pair.x[1][1] + t[1]}, {pair.x[0][0] - t[0], pair.x[0][1] - t[1]}}};
    const MortarWeights full = mortar_weights(pair.x, all, pair.edge);
    EXPECT_NEAR(full.D[0][1], 0, 1e-14);
    EXPECT_NEAR(full.D[1][0], 0, 1e-14);
    EXPECT_NEAR(full.D[0][0], pair.edge.length * (2 * pair.edge.ring[0] + pair.edge.ring[1]) / 6, 1e-14);
  }
}
