#include "../mesh/box_mesh.hpp"
#include "simulation_case.hpp"

// The damage equation alone: its drive is written into the state, so that a chosen phi is the solution.

namespace impact {
namespace {

using problem_test::Field;
using run_test::box_mesh;

constexpr double pi = std::numbers::pi;

/// Reference place of each quadrature point: body(x, index of its E+ in the row "drive").
template <class Body> void for_each_point(const Discretisation& d, Body&& body) {
  for_each_batch(d, all_laws, [&](const CellBatch& batch) {
    const Shape shape = batch.group.shape;
    const auto X = batch.vectors(d.mesh.coordinates());
    for (int q = 0; q < shape->points; ++q)
      for (int l = 0; l < lanes; ++l) {
        double x[3] = {0, 0, 0};
        for (int a = 0; a < shape->nodes; ++a)
          for (int k = 0; k < d.dim(); ++k)
            x[k] += shape->N[q * shape->nodes + a] * X.value[a * d.dim() + k][l];
        body(x, (batch.first_point + at((batch.number * shape->points + q) * lanes)) * drive_size + at(l));
      }
  });
}

struct DamageCase {
  Discretisation d;
  StateTable state;
  BoundaryData boundary;
  std::optional<DamageProblem> damage;

  DamageCase(Mesh mesh, const MaterialParameters& law, std::vector<BoundaryCondition> conditions,
             const DamageScenario& settings)
      : d(discretise(std::move(mesh), {{PointLaw{law}, {"solid"}}}, Frame::plane_strain, 1)),
        boundary(d.mesh, std::move(conditions), 1) {
    declare_state(d, state);
    damage.emplace(d, state, boundary, settings);
  }
  const std::vector<double>& u() { return state.row("u").committed; }

  /// One step from the committed phi and drive to the trial drive.
  void step(double t, double dt) {
    StateRow& phi = state.row("phi");
    phi.trial = phi.committed;
    const DamageStep now{.t = t, .dt = dt, .u = &u(), .u_n = &u(), .phi_n = &phi.committed};
    ASSERT_GT(damage->solve(now, phi.trial).reason, 0);
    state.commit();
  }
};

MaterialParameters brittle() {
  MaterialParameters law;
  law.K = 2;
  law.G = 1;
  law.damage = Damage::at2;
  law.Gc = 0.7;
  law.gamma = 0.3;
  return law;
}

/// phi = 0.3 + 0.2 prod sin(pi x_k) where Gc (phi/gamma - gamma Laplace phi) = 2 (1 - k) (1 - phi) E+.
void space_order(Shape shape, const std::array<int, 3>& meshes, const char* what) {
  const MaterialParameters law = brittle();
  const int dim = dimension(shape);
  const Field exact = [dim](const double* x, double) {
    double s = 0.2;
    for (int k = 0; k < dim; ++k) s *= std::sin(pi * x[k]);
    return 0.3 + s;
  };
  BoundaryCondition held;
  held.id = "held";
  held.on = {"boundary"};
  held.type = BcType::damage;
  held.value = problem_test::expression(exact);
  DamageScenario settings;
  settings.order = shape->order(); // of tetrahedra, too: no bound acts here
  double before = 0;
  for (std::size_t m = 0; m < 3; ++m) {
    DamageCase run(
        run_test::mesh_of(PETSC_COMM_WORLD, run_test::fresh_dir("damage_order"), box_mesh(shape, meshes[m])),
        law, {held}, settings);
    std::vector<double>& drive = run.state.row("drive").trial;
    for_each_point(run.d, [&](const double* x, std::size_t i) {
      const double phi = exact(x, 0), laplace = -dim * pi * pi * (phi - 0.3);
      drive[i] =
          law.Gc * (phi / law.gamma - law.gamma * laplace) / (2 * (1 - law.residual_stiffness) * (1 - phi));
      drive[i + lanes] = drive[i + 2 * lanes] = 0;
    });
    run.step(1, 1);
    const auto [error, size, slope] =
        problem_test::l2_error(run.d.mesh, run.state.row("phi").committed, 1, {exact}, 1);
    const double order = m == 0 ? 0 : std::log(before / error) / std::log(double(meshes[m]) / meshes[m - 1]);
    before = error;
    int rank = 0;
    MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
    if (rank == 0)
      std::printf("  %s, n = %d: L2 error of phi %.3e, order %.3f (reference %d)\n", what, meshes[m],
                  error / size, order, shape->order() + 1);
    if (m == 0) continue;
    EXPECT_GE(order, shape->order() + 0.9) << what;
    EXPECT_LE(order, shape->order() + 1.2) << what;
  }
}

TEST(DamageEquation, ConvergesWithOrderTwoInSpace) {
  space_order(Shape::quad4, {8, 16, 32}, "quad4");
  space_order(Shape::tri3, {8, 16, 32}, "tri3");
  space_order(Shape::hex8, {4, 8, 16}, "hex8");
  space_order(Shape::tet4, {4, 8, 16}, "tet4");
}

TEST(DamageEquation, ConvergesWithOrderThreeInCellsOfSecondOrder) {
  space_order(Shape::tri6, {8, 16, 32}, "tri6");
  space_order(Shape::tet10, {6, 9, 12}, "tet10");
  space_order(Shape::quad9, {8, 16, 32}, "quad9");
  space_order(Shape::hex27, {4, 6, 8}, "hex27");
}

/// phi(T) of the rate law phi_dot (1 - phi) = A (1 - phi) - B phi under a constant drive, from the closed
/// form t = (phi - (1 - phi_e) ln(1 - phi/phi_e))/(A + B), phi_e = A/(A + B).
double rate_law(double A, double B, double T) {
  const double rest = A / (A + B);
  double low = 0, high = rest;
  for (int i = 0; i < 200; ++i) {
    const double middle = (low + high) / 2;
    (middle - (1 - rest) * std::log1p(-middle / rest) < (A + B) * T ? low : high) = middle;
  }
  return (low + high) / 2;
}

// Table 1 of the paper, E+ = 5e6 J/m^3. lambda stays at t_n in every scheme: first order for both, with
// different constants.
TEST(DamageEquation, FollowsTheRateLawWithOrderOneInTime) {
  MaterialParameters law = brittle();
  law.Gc = 4950.6;
  law.gamma = 0.5e-3;
  law.c = 1e-3;
  law.residual_stiffness = 0;
  const double E = 5e6, T = 8.02872e-5, exact = rate_law(2 * E * law.c, law.Gc / law.gamma * law.c, T);
  EXPECT_NEAR(exact, 0.9 * 0.502482, 1e-6);
  for (const auto& [form, theta, what] :
       {std::tuple{DamageForm::multiplied, 1., "backward Euler, multiplied"},
        {DamageForm::divided, 1., "backward Euler, divided"},
        {DamageForm::divided, 0.5, "trapezoid, divided"}}) {
    double before = 0;
    for (const int steps : {20, 40, 80}) {
      DamageCase run(
          run_test::mesh_of(PETSC_COMM_WORLD, run_test::fresh_dir("damage_order"), box_mesh(Shape::quad4, 2)),
          law, {}, {.form = form, .theta = theta});
      std::vector<double>&now = run.state.row("drive").trial, &old = run.state.row("drive").committed;
      for_each_point(run.d, [&](const double*, std::size_t i) { now[i] = old[i] = E; });
      for (int i = 1; i <= steps; ++i) run.step(i * T / steps, T / steps);
      const std::vector<double>& phi = run.state.row("phi").committed;
      const double mine = phi.empty() ? 0 : phi[0] - exact;
      double error = 0;
      MPI_Allreduce(&mine, &error, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
      int holders = phi.empty() ? 0 : 1, rank = 0;
      MPI_Allreduce(MPI_IN_PLACE, &holders, 1, MPI_INT, MPI_SUM, PETSC_COMM_WORLD);
      error /= holders;
      MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
      const double order = before == 0 ? 0 : std::log2(std::abs(before / error));
      if (rank == 0)
        std::printf("  %s, %d steps: phi - %.6f = %.3e, order %.3f (reference 1)\n", what, steps, exact,
                    error, order);
      if (before != 0) {
        EXPECT_GE(order, 0.9) << what;
        EXPECT_LE(order, 1.1) << what;
      }
      before = error;
    }
  }
}

} // namespace
} // namespace impact
