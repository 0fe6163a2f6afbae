#include <cmath>
#include <gtest/gtest.h>
#include <impact/kernel/boundary_load.hpp>
#include <numbers>
#include <random>
#include <vector>

using namespace impact;

namespace {

std::vector<double> pressure_force(int nodes, Frame frame, const std::vector<double>& x, double p,
                                   double* K = nullptr) {
  std::vector<double> f(x.size(), 0.0);
  for (int q = 0; q < nodes; ++q)
    add_follower_pressure(facet_point(dimension(frame), nodes, q), nodes, frame, x.data(), p, f.data(), K);
  return f;
}

struct FacetCase {
  int nodes;
  Frame frame;
};
const FacetCase facet_cases[] = {{2, Frame::plane_strain}, {2, Frame::axisymmetric}, {3, Frame::plane_strain},
                                 {3, Frame::axisymmetric}, {3, Frame::solid},        {4, Frame::solid},
                                 {6, Frame::solid}};

// A facet as its corners, then the middles of its edges.
int corner_count(const FacetCase& c) { return c.frame != Frame::solid ? 2 : c.nodes == 6 ? 3 : c.nodes; }

std::vector<double> facet(const FacetCase& c, std::mt19937& random) {
  std::uniform_real_distribution<double> noise(-0.1, 0.1);
  const double corner[4][3] = {{1, 0, 0}, {2, 0.2, 0}, {2, 1, 0.3}, {1, 1, 0}};
  std::vector<double> x;
  const int corners = corner_count(c);
  for (int a = 0; a < c.nodes; ++a)
    for (int i = 0; i < dimension(c.frame); ++i) {
      const int from = a % corners, to = (from + 1) % corners;
      x.push_back((a < corners ? corner[a][i] : (corner[from][i] + corner[to][i]) / 2) + noise(random));
    }
  return x;
}

} // namespace

TEST(BoundaryLoad,
     PressureTangentIsTheDerivativeOfTheForce) { // polynomials of degree 2 per node: central differences
  std::mt19937 random(1);
  for (const FacetCase& c : facet_cases) {
    const auto x = facet(c, random);
    const std::size_t n = x.size();
    std::vector<double> K(n * n, 0.0);
    pressure_force(c.nodes, c.frame, x, 3, K.data());
    for (std::size_t j = 0; j < n; ++j) {
      auto up = x, down = x;
      const double h = 1e-3;
      up[j] += h;
      down[j] -= h;
      const auto a = pressure_force(c.nodes, c.frame, up, 3), b = pressure_force(c.nodes, c.frame, down, 3);
      for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(K[i * n + j], (a[i] - b[i]) / (2 * h), 1e-11);
    }
  }
}

TEST(BoundaryLoad, PressureOnAClosedSurfaceHasNoResultantAndPushesInward) {
  // a sheared cube, faces counter-clockwise seen from outside
  const int face[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
  double X[8][3], force[8][3] = {}, moment = 0;
  for (int a = 0; a < 8; ++a) {
    X[a][0] = (a % 4 == 1 || a % 4 == 2) + 0.2 * (a / 4);
    X[a][1] = (a % 4 > 1) + 0.1 * X[a][0];
    X[a][2] = a / 4;
  }
  X[6][2] += 0.3;
  for (const auto& nodes : face) {
    std::vector<double> x;
    for (int a : nodes) x.insert(x.end(), X[a], X[a] + 3);
    const auto f = pressure_force(4, Frame::solid, x, 7);
    for (int a = 0; a < 4; ++a)
      for (int i = 0; i < 3; ++i) force[nodes[a]][i] += f[unsigned(3 * a + i)];
  }
  double virial = 0;
  for (int i = 0; i < 3; ++i) {
    double sum = 0;
    for (int a = 0; a < 8; ++a) sum += force[a][i], virial += force[a][i] * X[a][i];
    EXPECT_NEAR(sum, 0, 1e-13);
  }
  for (int a = 0; a < 8; ++a) moment += X[a][0] * force[a][1] - X[a][1] * force[a][0];
  EXPECT_NEAR(moment, 0, 1e-12);
  EXPECT_LT(virial, -3 * 7 * 0.9); // -3 p V: the load points into the body
}

TEST(BoundaryLoad, DeadTractionCarriesTractionTimesArea) {
  const double t[3] = {2, -3, 5};
  const double line[4] = {1, 0, 4, 4}, triangle[9] = {0, 0, 0, 2, 0, 0, 0, 0, 3},
               square[12] = {0, 0, 1, 2, 0, 1, 2, 2, 1, 0, 2, 1};
  const auto total = [&](int nodes, Frame frame, const double* X, int component) {
    double f[12] = {}, sum = 0;
    for (int q = 0; q < nodes; ++q)
      add_dead_traction(facet_point(dimension(frame), nodes, q), nodes, frame, X, t, f);
    for (int a = 0; a < nodes; ++a) sum += f[a * dimension(frame) + component];
    return sum;
  };
  EXPECT_NEAR(total(2, Frame::plane_strain, line, 0), 2 * 5, 1e-13);
  EXPECT_NEAR(total(2, Frame::axisymmetric, line, 1), -3 * 5 * 2 * std::numbers::pi * 2.5, 1e-12);
  EXPECT_NEAR(total(3, Frame::solid, triangle, 2), 5 * 3, 1e-13);
  EXPECT_NEAR(total(4, Frame::solid, square, 1), -3 * 4, 1e-13);
}

// A parabola y = x^2/2 of length (sqrt(2) + asinh(1))/2, and a triangle raised to z = x y in its plane area
// 1/2.
TEST(BoundaryLoad, CurvedFacetsOfSecondOrderHaveTheirAreaAndTheirNormal) {
  const double arc[6] = {0, 0, 1, 0.5, 0.5, 0.125};
  double length = 0;
  for (int q = 0; q < 3; ++q) length += reference_area(facet_point(2, 3, q), 3, Frame::plane_strain, arc);
  EXPECT_NEAR(length, (std::sqrt(2.0) + std::asinh(1.0)) / 2, 2e-4);
  const std::vector<double> cap = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0.5, 0, 0, 0.5, 0.5, 0.25, 0, 0.5, 0};
  const auto f = pressure_force(6, Frame::solid, cap, 2);
  double sum[3] = {0, 0, 0};
  for (std::size_t k = 0; k < f.size(); ++k) sum[k % 3] += f[k];
  // -p int (-z_,x, -z_,y, 1) over the plane triangle, z_,x = y
  EXPECT_NEAR(sum[0], 2.0 / 6, 1e-14);
  EXPECT_NEAR(sum[1], 2.0 / 6, 1e-14);
  EXPECT_NEAR(sum[2], -2.0 / 2, 1e-14);
}

TEST(BoundaryLoad,
     PressureOnALineActsAgainstTheOutwardNormal) { // body on the left of the way from (0,0) to (2,0)
  const auto f = pressure_force(2, Frame::plane_strain, {0, 0, 2, 0}, 3);
  EXPECT_NEAR(f[1] + f[3], 6, 1e-14); // outward is -y, the pressure pushes up
  EXPECT_NEAR(f[0] + f[2], 0, 1e-14);
  double x[2];
  facet_position(facet_point(2, 2, 0), 2, 2, std::vector<double>{0, 0, 2, 0}.data(), x);
  EXPECT_NEAR(x[0], 1 - 1 / std::sqrt(3.0), 1e-15);
}
