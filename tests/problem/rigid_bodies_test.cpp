#include "../mesh/small_mesh.hpp"
#include <gtest/gtest.h>
#include <impact/petsc/error.hpp>
#include <impact/problem/motion.hpp>

namespace impact {
namespace {

// An elastic body under a rigid one that presses on it.
struct RigidOnElastic {
  Discretisation d;
  StateTable state;
  RigidBodies rigid;
  BoundaryData boundary;
  ContactSet contacts;
  std::optional<MotionProblem> motion;

  explicit RigidOnElastic(double friction)
      : d(discretise(run_test::mesh_of(PETSC_COMM_WORLD, run_test::fresh_dir("rigid_bodies"),
                                       run_test::two_bodies(4, 0.1)),
                     {{PointLaw{elastic()}, {"lower"}, "rubber"}, {PointLaw{tool()}, {"upper"}, "tool"}},
                     Frame::plane_strain, 1)),
        rigid(d, {}, 1), boundary(d.mesh, {}, 1, rigid.body_of_node()) {
    declare_state(d, state);
    rigid.declare_state(state);
    ContactSettings settings;
    settings.id = "face";
    settings.secondary = "upper_bottom";
    settings.primary = "lower top";
    settings.method = ContactMethod::mortar;
    settings.enforce = Enforcement::penalty;
    settings.friction = friction;
    settings.initial = InitialOverlap::allow;
    ContactEnvironment environment;
    environment.modulus = environment.density = 1;
    contacts.emplace_back(d.mesh, d.displacement, settings, environment, state);
    motion.emplace(d, state, boundary, contacts, false, ContactOperator::assembled, MatrixFormat::aij,
                   &rigid);
  }
  static MaterialParameters elastic() {
    MaterialParameters m;
    m.K = m.G = m.rho = 1;
    return m;
  }
  static MaterialParameters tool() {
    MaterialParameters m;
    m.model = Model::rigid;
    m.rho = 2;
    return m;
  }
  // Smooth and of all directions, [node][dim] by reference coordinates.
  Handle<Vec> field(double size, double phase) const {
    std::vector<double> values = d.displacement.make_local();
    const auto X = d.mesh.coordinates();
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] =
          size * std::sin(phase + 3 * X[i / 2 * 2] - 2 * X[i / 2 * 2 + 1] + static_cast<double>(i % 2));
    Handle<Vec> u = d.displacement.make_global();
    d.displacement.to_global(values, u);
    return u;
  }
};

double norm(Vec f) {
  PetscReal size = 0;
  check(VecNorm(f, NORM_2, &size));
  return size;
}

// The residual along a path of rigid motions changes as the tangent says: with inertia, contact with and
// without friction, test functions of the middle or the end of the step.
TEST(RigidBodies, TheTangentIsTheDerivativeOfTheResidual) {
  for (const double friction : {0.0, 0.3})
    for (const double shift : {0.0, 7.0}) {
      RigidOnElastic run(friction);
      MotionStep step;
      step.t = step.dt = 1;
      step.mass_shift = shift;
      const std::vector<double> start = run.state.row("u").committed;
      step.u_n = &start;
      run.motion->begin(step);
      // Turned by a tenth and pressed in.
      Handle<Vec> u = run.field(0.02, 0.3);
      std::vector<double> local = run.d.displacement.make_local();
      run.d.displacement.to_local(u, local);
      const auto X = run.d.mesh.coordinates();
      for (std::size_t node = 0; node < run.rigid.body_of_node().size(); ++node)
        if (run.rigid.body_of_node()[node] >= 0) {
          local[2 * node] -= 0.1 * X[2 * node + 1];
          local[2 * node + 1] += 0.1 * (X[2 * node] - 0.6) - 0.04;
        }
      run.d.displacement.to_global(local, u);
      run.motion->update_contact(u);
      run.rigid.retract(u);
      // a = shift (u - u_0) stands for what an integrator would say.
      const auto residual = [&](Vec at, Vec f) {
        Handle<Vec> a = run.d.displacement.make_global();
        check(VecCopy(at, a));
        check(VecScale(a, shift));
        ASSERT_TRUE(run.motion->residual(at, shift > 0 ? a.get() : nullptr, f));
      };
      Handle<Vec> f = run.d.displacement.make_global(), plus = run.d.displacement.make_global(),
                  minus = run.d.displacement.make_global(), product = run.d.displacement.make_global();
      residual(u, f);
      ASSERT_TRUE(run.motion->tangent(u, shift));
      EXPECT_GT(run.contacts[0].measures(u).active, 1);
      const Handle<Vec> y = run.field(1, 1.1);
      Handle<Vec> du = run.d.displacement.make_global();
      check(VecCopy(y, du));
      check(MatMult(run.motion->matrix(), y, product));
      run.rigid.expand(u, du);
      // Rows without an unknown are identities.
      std::vector<double> rows = run.d.displacement.make_local();
      run.d.displacement.to_local(product, rows);
      for (int dof : run.rigid.idle_dofs()) rows[static_cast<std::size_t>(dof)] = 0;
      run.d.displacement.to_global(rows, product);
      const double h = 1e-6;
      Handle<Vec> at = run.d.displacement.make_global();
      for (const double sign : {1.0, -1.0}) {
        check(VecWAXPY(at, sign * h, du, u));
        run.rigid.retract(at);
        residual(at, sign > 0 ? plus : minus);
      }
      check(VecAXPY(plus, -1, minus));
      check(VecScale(plus, 1 / (2 * h)));
      const double size = norm(plus);
      check(VecAXPY(plus, -1, product));
      EXPECT_LT(norm(plus), 1e-7 * size) << "friction " << friction << ", mass shift " << shift;
    }
}

// Nodes of a body that do not stand for its unknowns cost the factors of the tangent nothing.
TEST(RigidBodies, CellsOfABodyCoupleNothingInTheTangent) {
  RigidOnElastic run(0);
  const std::vector<int>& idle = run.rigid.idle_dofs();
  int nodes = 0;
  for (std::size_t i = 0; i + 1 < idle.size(); ++i) {
    if (idle[i] % 2 != 0 || idle[i + 1] != idle[i] + 1) continue;
    const PetscInt row = 2 * run.d.mesh.global_node()[static_cast<std::size_t>(idle[i] / 2)];
    PetscInt entries = 0;
    check(MatGetRow(run.motion->matrix(), row, &entries, nullptr, nullptr));
    EXPECT_EQ(entries, 2) << "row " << row;
    check(MatRestoreRow(run.motion->matrix(), row, &entries, nullptr, nullptr));
    ++nodes;
  }
  int all = nodes;
  MPI_Allreduce(MPI_IN_PLACE, &all, 1, MPI_INT, MPI_SUM, run.d.mesh.comm());
  EXPECT_EQ(all, static_cast<int>(5 * 3 - 2)); // all nodes of the body but two
}

TEST(RigidBodies, MassAndInertiaAreThoseOfTheMesh) {
  RigidOnElastic run(0);
  ASSERT_EQ(run.rigid.bodies().size(), 1u);
  const RigidBody& body = run.rigid.bodies()[0];
  EXPECT_EQ(body.name, "tool");
  EXPECT_NEAR(body.mass, 2 * 1 * 0.5, 1e-14); // 1 x 0.5
  EXPECT_NEAR(body.centre[0], 0.6, 1e-14);
  EXPECT_NEAR(body.centre[1], 0.75, 1e-14);
  EXPECT_NEAR(body.second[0] + body.second[4], body.mass * (1 + 0.25) / 12, 1e-14);
}

TEST(RigidBodies, RetractionKeepsRigidMotionsAndIsOneForOthers) {
  RigidOnElastic run(0);
  const std::vector<double> start = run.state.row("u").committed;
  run.rigid.begin(0, 1, start, true);
  Handle<Vec> u = run.field(0.3, 0.2), again = run.d.displacement.make_global();
  run.rigid.retract(u);
  check(VecCopy(u, again));
  run.rigid.retract(again);
  check(VecAXPY(again, -1, u));
  EXPECT_LT(norm(again), 1e-15 * 100);
  std::vector<double> local = run.d.displacement.make_local();
  run.d.displacement.to_local(u, local);
  const auto X = run.d.mesh.coordinates();
  // Distances of nodes stay, far as the body turned.
  double farthest = 0;
  std::size_t first = local.size();
  for (std::size_t node = 0; node < run.rigid.body_of_node().size(); ++node) {
    if (run.rigid.body_of_node()[node] < 0) continue;
    if (first == local.size()) first = node;
    const double X0 = X[2 * node] - X[2 * first], Y0 = X[2 * node + 1] - X[2 * first + 1];
    const double x = X0 + local[2 * node] - local[2 * first],
                 y = Y0 + local[2 * node + 1] - local[2 * first + 1];
    EXPECT_NEAR(std::hypot(x, y), std::hypot(X0, Y0), 1e-15);
    farthest = std::max(farthest, std::abs(local[2 * node]));
  }
  if (first < local.size()) {
    EXPECT_GT(farthest, 0.01);
  }
}

// The shorter way round, wherever the body is.
TEST(RigidBodies, TheAngleBetweenTwoPlacesIsThatOfTheTurn) {
  RigidOnElastic run(0);
  run.rigid.begin(0, 1, run.state.row("u").committed, true);
  const auto turned = [&](double angle) {
    std::vector<double> local = run.d.displacement.make_local();
    const auto X = run.d.mesh.coordinates();
    for (std::size_t i = 0; i < local.size() / 2; ++i) {
      const double x = X[2 * i] - 0.6, y = X[2 * i + 1] - 0.75;
      local[2 * i] = std::cos(angle) * x - std::sin(angle) * y - x + 0.1;
      local[2 * i + 1] = std::sin(angle) * x + std::cos(angle) * y - y;
    }
    Handle<Vec> u = run.d.displacement.make_global();
    run.d.displacement.to_global(local, u);
    run.rigid.retract(u);
    return u;
  };
  const Handle<Vec> goal = turned(0.4), near = turned(1.2), far = turned(0.4 - 3.1);
  EXPECT_NEAR(run.rigid.most_turned(goal, near).first, 0.8, 1e-12);
  EXPECT_NEAR(run.rigid.most_turned(goal, far).first, 3.1, 1e-12);
}

} // namespace
} // namespace impact
