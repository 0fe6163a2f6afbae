#include "../mesh/small_mesh.hpp"
#include <gtest/gtest.h>
#include <impact/problem/rigid_motion.hpp>

namespace impact {
namespace {

using Words = std::vector<std::string>;

// A strip of n x 1 unit squares (or cubes), region "strip", with the points "first" at the origin, "beside"
// at the other end of the first square's lower edge, "above" over the origin, "last" at (n, 1), and the edge
// "bottom"; in space the edge "axle" from the origin along y.
std::string strip(int n, bool solid) {
  run_test::GmshText mesh;
  std::vector<int> id;
  for (int k = 0; k <= (solid ? 1 : 0); ++k)
    for (int j = 0; j <= 1; ++j)
      for (int i = 0; i <= n; ++i) id.push_back(mesh.node(i, j, k));
  const auto at = [&](int i, int j, int k = 0) {
    return id[static_cast<std::size_t>((k * 2 + j) * (n + 1) + i)];
  };
  for (int i = 0; i < n; ++i) {
    if (solid)
      mesh.element(5, 1,
                   {at(i, 0), at(i + 1, 0), at(i + 1, 1), at(i, 1), at(i, 0, 1), at(i + 1, 0, 1),
                    at(i + 1, 1, 1), at(i, 1, 1)});
    else
      mesh.element(3, 1, {at(i, 0), at(i + 1, 0), at(i + 1, 1), at(i, 1)});
  }
  mesh.element(15, 2, {at(0, 0)});
  mesh.element(15, 3, {at(1, 0)});
  mesh.element(15, 4, {at(0, 1)});
  mesh.element(15, 5, {at(n, 1)});
  for (int i = 0; i < n; ++i) {
    if (solid)
      mesh.element(3, 6, {at(i, 0), at(i + 1, 0), at(i + 1, 0, 1), at(i, 0, 1)});
    else
      mesh.element(1, 6, {at(i, 0), at(i + 1, 0)});
  }
  const std::string dim = solid ? "3" : "2", below = solid ? "2" : "1";
  return mesh.text("6\n" + dim +
                   " 1 \"strip\"\n0 2 \"first\"\n0 3 \"beside\"\n0 4 \"above\"\n0 5 \"last\"\n" + below +
                   " 6 \"bottom\"\n");
}

BoundaryCondition hold(const std::string& group, const std::string& components) {
  BoundaryCondition bc;
  bc.id = group;
  bc.on = {group};
  for (const char c : components)
    bc.component[c - 'x'] = Expression("test", [](const double*, int, double) { return 0.0; });
  return bc;
}

std::vector<FreeBody> free_bodies(const std::string& text, const Words& regions,
                                  std::vector<BoundaryCondition> conditions, bool axisymmetric = false) {
  MaterialParameters law;
  law.K = law.G = 1;
  const Discretisation d =
      discretise(run_test::mesh_of(PETSC_COMM_WORLD, run_test::fresh_dir("rigid"), text),
                 {{PointLaw{law}, regions}}, axisymmetric ? Frame::axisymmetric : Frame::plane_strain, 1);
  const BoundaryData boundary(d.mesh, std::move(conditions), 1);
  return find_free_bodies(d, boundary);
}

// Motions of the one body that the strip is; empty where it is held.
Words motions(int n, bool solid, std::vector<BoundaryCondition> conditions, bool axisymmetric = false) {
  const auto bodies = free_bodies(strip(n, solid), {"strip"}, std::move(conditions), axisymmetric);
  if (bodies.empty()) return {};
  EXPECT_EQ(bodies.size(), 1u);
  EXPECT_EQ(bodies.front().regions, "strip");
  return bodies.front().motions;
}

TEST(RigidMotion, ABodyInThePlaneHasThreeUntilItIsHeld) {
  EXPECT_EQ(motions(8, false, {}), (Words{"translation in x", "translation in y", "rotation"}));
  EXPECT_EQ(motions(8, false, {hold("bottom", "y")}), Words{"translation in x"});
  EXPECT_EQ(motions(8, false, {hold("first", "y")}), (Words{"translation in x", "rotation"}));
  EXPECT_EQ(motions(8, false, {hold("bottom", "xy")}), Words{});
}

TEST(RigidMotion, AHeldPointLeavesTheRotationAboutIt) {
  EXPECT_EQ(motions(8, false, {hold("first", "xy")}), Words{"rotation about (0, 0)"});
  EXPECT_EQ(motions(8, false, {hold("last", "xy")}), Words{"rotation about (8, 1)"});
  // A second point stops the rotation only across the line to the first.
  EXPECT_EQ(motions(8, false, {hold("first", "xy"), hold("beside", "x")}), Words{"rotation about (0, 0)"});
  EXPECT_EQ(motions(8, false, {hold("first", "xy"), hold("beside", "y")}), Words{});
  EXPECT_EQ(motions(8, false, {hold("first", "xy"), hold("above", "y")}), Words{"rotation about (0, 0)"});
  EXPECT_EQ(motions(8, false, {hold("first", "xy"), hold("above", "x")}), Words{});
}

TEST(RigidMotion, GuidesWhoseNormalsMeetLeaveTheRotationAboutTheMeetingPoint) {
  // (1, 0) slides along x and (8, 1) along y: their normals meet in (1, 1).
  EXPECT_EQ(motions(8, false, {hold("beside", "y"), hold("last", "x")}), Words{"rotation about (1, 1)"});
}

TEST(RigidMotion, ALongBodyHeldAtTwoNeighboursIsHeld) {
  EXPECT_EQ(motions(2000, false, {hold("first", "xy"), hold("beside", "y")}), Words{});
  EXPECT_EQ(motions(2000, false, {hold("first", "xy"), hold("beside", "x")}), Words{"rotation about (0, 0)"});
}

TEST(RigidMotion, ARingCanOnlyMoveAlongItsAxis) {
  EXPECT_EQ(motions(4, false, {hold("bottom", "x")}, true), Words{"translation in y, along the axis"});
  EXPECT_EQ(motions(4, false, {hold("first", "y")}, true), Words{});
}

TEST(RigidMotion, ABodyInSpaceHasSixUntilItIsHeld) {
  EXPECT_EQ(motions(4, true, {}), (Words{"translation in x", "translation in y", "translation in z",
                                         "rotation about x", "rotation about y", "rotation about z"}));
  EXPECT_EQ(motions(4, true, {hold("bottom", "y")}),
            (Words{"translation in x", "translation in z", "rotation about y"}));
  EXPECT_EQ(motions(4, true, {hold("first", "xyz")}),
            (Words{"rotation about x", "rotation about y", "rotation about z"}));
  EXPECT_EQ(motions(4, true, {hold("first", "xyz"), hold("above", "xyz")}), Words{"rotation about y"});
  // The line from (0, 0, 0) to (4, 1, 0).
  EXPECT_EQ(motions(4, true, {hold("first", "xyz"), hold("last", "xyz")}).size(), 1u);
  EXPECT_EQ(motions(4, true, {hold("first", "xyz"), hold("above", "xyz"), hold("beside", "z")}), Words{});
}

TEST(RigidMotion, EachBodyIsJudgedByItself) {
  const auto both = free_bodies(run_test::two_bodies(6), {"lower", "upper"}, {});
  ASSERT_EQ(both.size(), 2u);
  const auto upper = free_bodies(run_test::two_bodies(6), {"lower", "upper"}, {hold("lower top", "xy")});
  ASSERT_EQ(upper.size(), 1u);
  EXPECT_EQ(upper.front().regions, "upper");
  EXPECT_NEAR(upper.front().centre[0], 0.75, 1e-12);
  EXPECT_NEAR(upper.front().centre[1], 0.75, 1e-12);
  EXPECT_EQ(upper.front().motions, (Words{"translation in x", "translation in y", "rotation"}));
  EXPECT_TRUE(free_bodies(run_test::two_bodies(6), {"lower", "upper"},
                          {hold("lower top", "xy"), hold("upper_bottom", "xy")})
                  .empty());
}

} // namespace
} // namespace impact
