#include <cmath>
#include <gtest/gtest.h>
#include <impact/math/rotation.hpp>
#include <impact/petsc/error.hpp>
#include <impact/run/obstacle_body.hpp>
#include <numbers>

namespace impact {
namespace {

constexpr std::array<double, 6> box = {0, 0, 0, 3, 4, 12};

ContactScenario contact(const std::string& shape) {
  ContactScenario c;
  c.id = "foot";
  c.primary = shape;
  c.carrier = "obstacle_foot";
  c.rigid_mass = 7;
  c.radius = 0.4;
  c.centre[0] = c.plane_point[0] = 0.3;
  c.centre[1] = c.plane_point[1] = -0.2;
  c.centre[2] = c.plane_point[2] = 0.6;
  const double axis[3] = {2, -1, 2};
  std::copy(axis, axis + 3, c.axis);
  return c;
}

struct Inertia {
  double mass = 0;
  Vector3 centre{};
  Matrix3 about{}; // the centre of mass
};

// By quadrature that is exact for quadratic functions: four points of a tetrahedron, the middles of the sides
// of a triangle; per thickness, or of the full ring.
Inertia measured(const ObstacleBody& body, bool ring = false) {
  const auto& X = body.cell.corner;
  const Vector3 a = {X[1][0] - X[0][0], X[1][1] - X[0][1], X[1][2] - X[0][2]},
                b = {X[2][0] - X[0][0], X[2][1] - X[0][1], X[2][2] - X[0][2]}, n = cross(a, b);
  std::vector<Vector3> points;
  double volume = n[2] / 2;
  const double main = X.size() == 4 ? 0.25 + 0.75 / std::sqrt(5.0) : 0,
               other = X.size() == 4 ? (1 - main) / 3 : 0.5;
  if (X.size() == 4)
    volume = (n[0] * (X[3][0] - X[0][0]) + n[1] * (X[3][1] - X[0][1]) + n[2] * (X[3][2] - X[0][2])) / 6;
  EXPECT_GT(volume, 0);
  for (std::size_t p = 0; p < X.size(); ++p) {
    Vector3 x{};
    for (std::size_t c = 0; c < X.size(); ++c)
      for (std::size_t k = 0; k < 3; ++k) x[k] += (c == p ? main : other) * X[c][k];
    points.push_back(x);
  }
  Inertia sum;
  for (const bool moments : {false, true})
    for (const Vector3& x : points) {
      const double m = body.density * volume / static_cast<double>(points.size()) *
                       (ring ? 2 * std::numbers::pi * x[0] : 1);
      if (!moments) {
        sum.mass += m;
        for (std::size_t k = 0; k < 3; ++k) sum.centre[k] += m * x[k];
        continue;
      }
      Vector3 y{};
      for (std::size_t k = 0; k < 3; ++k) y[k] = x[k] - sum.centre[k] / sum.mass;
      const double square = y[0] * y[0] + y[1] * y[1] + y[2] * y[2];
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) sum.about[3 * i + j] += m * ((i == j ? square : 0) - y[i] * y[j]);
    }
  for (double& component : sum.centre) component /= sum.mass;
  return sum;
}

// Moments about the axis (2, -1, 2)/3 and across it.
void expect_inertia(const Inertia& found, double about, double across) {
  const Vector3 a = {2.0 / 3, -1.0 / 3, 2.0 / 3};
  EXPECT_NEAR(found.mass, 7, 1e-13);
  EXPECT_NEAR(found.centre[0], 0.3, 1e-14);
  EXPECT_NEAR(found.centre[1], -0.2, 1e-14);
  EXPECT_NEAR(found.centre[2], 0.6, 1e-14);
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      EXPECT_NEAR(found.about[3 * i + j], (i == j ? across : 0) + (about - across) * a[i] * a[j], 1e-13);
}

} // namespace

TEST(ObstacleBody, SolidsHaveTheMassAndTheInertiaOfTheirShapes) {
  const auto make = [](const ContactScenario& c) { return obstacle_body(c, 3, PlaneMode::strain, 1, box); };
  expect_inertia(measured(make(contact("rigid_sphere"))), 0.4 * 7 * 0.16, 0.4 * 7 * 0.16);
  ContactScenario cylinder = contact("rigid_cylinder");
  EXPECT_THROW(make(cylinder), UserError);
  cylinder.rigid_length = 1.5;
  expect_inertia(measured(make(cylinder)), 7 * 0.16 / 2, 7 * (3 * 0.16 + 2.25) / 12);
  ContactScenario plane = contact("plane");
  plane.rigid_inertia = 3.3;
  expect_inertia(measured(make(plane)), 3.3, 3.3);
  // One that does not turn is small beside the mesh.
  plane = contact("plane");
  const ObstacleBody body = make(plane);
  EXPECT_NEAR(measured(body).mass, 7, 1e-13);
  EXPECT_EQ(body.cell.region, "obstacle_foot");
}

TEST(ObstacleBody, PlaneBodiesHaveTheirMassOverTheThicknessRingsOverTheCircle) {
  const Inertia disc = measured(obstacle_body(contact("rigid_cylinder"), 2, PlaneMode::strain, 0.25, box));
  EXPECT_NEAR(0.25 * disc.mass, 7, 1e-13);
  EXPECT_NEAR(0.25 * disc.about[8], 7 * 0.16 / 2, 1e-13);
  EXPECT_NEAR(disc.centre[0], 0.3, 1e-14);
  EXPECT_NEAR(disc.centre[1], -0.2, 1e-14);
  for (const char* shape : {"rigid_sphere", "plane"}) {
    const ObstacleBody body = obstacle_body(contact(shape), 2, PlaneMode::axisymmetric, 1, box);
    const Inertia ring = measured(body, true);
    EXPECT_NEAR(ring.mass, 7, 1e-13) << shape;
    EXPECT_NEAR(ring.centre[1], -0.2, 1e-14) << shape;
  }
}

TEST(ObstacleBody, WhatIsGivenIsPrescribedAndAPlaneWithoutInertiaDoesNotTurn) {
  Scenario scenario;
  scenario.contacts = {contact("plane"), contact("rigid_sphere")};
  scenario.contacts[1].carrier = "obstacle_ball";
  scenario.contacts[0].rigid_u[0] = Expression("key", "t");
  const std::vector<BoundaryCondition> all = obstacle_conditions(scenario, 3);
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].on, std::vector<std::string>{"obstacle_foot"});
  EXPECT_TRUE(all[0].component[0] && !all[0].component[1] && !all[0].component[2]);
  EXPECT_TRUE(all[0].rotation[0] && all[0].rotation[1] && all[0].rotation[2]);
  const std::vector<BoundaryCondition> flat = obstacle_conditions(scenario, 2);
  EXPECT_TRUE(!flat[0].rotation[0] && !flat[0].rotation[1] && flat[0].rotation[2]);
  scenario.contacts[0].rigid_inertia = 1;
  EXPECT_FALSE(obstacle_conditions(scenario, 3)[0].rotation[1]);
}

} // namespace impact
