#include "../mesh/box_mesh.hpp"
#include "simulation_case.hpp"
#include <impact/problem/heat.hpp>

// The heat equation alone, with sources that make a chosen temperature its solution.

namespace impact {
namespace {

using problem_test::expression;
using problem_test::Field;
using run_test::box_mesh;

constexpr double pi = std::numbers::pi;

MaterialParameters conductor() {
  MaterialParameters law;
  law.K = 2;
  law.G = 1;
  law.c_v = 1.7;
  law.theta0 = 300;
  law.conductivity = 0.4;
  return law;
}

BoundaryCondition scalar_condition(std::string id, std::string on, BcType type, Field value) {
  BoundaryCondition bc;
  bc.id = std::move(id);
  bc.on = {std::move(on)};
  bc.type = type;
  bc.value = expression(std::move(value));
  return bc;
}

struct HeatCase {
  Discretisation d;
  StateTable state;
  BoundaryData boundary;
  HeatProblem heat;

  HeatCase(Mesh mesh, bool ring, const MaterialParameters& law, std::vector<BoundaryCondition> conditions,
           const HeatScenario& settings)
      : d(discretise(std::move(mesh), {{PointLaw{law}, {"solid"}}},
                     ring ? Frame::axisymmetric : Frame::plane_strain, 1)),
        boundary(d.mesh, std::move(conditions), 1), heat(declared(), state, boundary, settings, false) {}

  /// From the exact temperature at t = 0 to t_end.
  void run(const Field& exact, double t_end, int steps) {
    StateRow& theta = state.row("theta");
    for (std::size_t i = 0; i < theta.trial.size(); ++i)
      theta.trial[i] = exact(&d.mesh.coordinates()[i * static_cast<std::size_t>(d.dim())], 0);
    state.commit();
    for (int n = 1; n <= steps; ++n) {
      heat.begin((n - 1) * t_end / steps, n * t_end / steps);
      ASSERT_GT(heat.solve({}, theta.trial).reason, 0);
      state.commit();
    }
  }
  const std::vector<double>& theta() { return state.row("theta").committed; }

private:
  const Discretisation& declared() {
    declare_state(d, state);
    return d;
  }
};

Mesh mesh_of(Shape shape, int n) {
  return run_test::mesh_of(PETSC_COMM_WORLD, run_test::fresh_dir("heat_order"), box_mesh(shape, n));
}

void say(const char* what, const char* unit, int count, double error, double order) {
  int rank = 0;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  if (rank == 0)
    std::printf("  %s, %d %s: L2 error of theta %.3e, order %.3f\n", what, count, unit, error, order);
}

/// A steady field on three meshes: -kappa Laplace theta = source, theta given all around.
void space_order(Shape shape, const std::array<int, 3>& meshes, bool ring, const char* what) {
  const MaterialParameters law = conductor();
  const int dim = dimension(shape);
  const Field exact = [dim](const double* x, double) {
    double s = 40;
    for (int k = 0; k < dim; ++k) s *= std::sin(pi * x[k] + 0.3);
    return 300 + s;
  };
  const Field source = [&law, exact, dim, ring](const double* x, double) {
    const double s = exact(x, 0) - 300;
    double laplace = -dim * pi * pi * s;
    if (ring) laplace += pi * s / std::tan(pi * x[0] + 0.3) / x[0]; // theta_,R / R
    return -law.conductivity * laplace;
  };
  double before = 0;
  for (std::size_t m = 0; m < 3; ++m) {
    HeatCase run(mesh_of(shape, meshes[m]), ring, law,
                 {scalar_condition("held", "boundary", BcType::temperature, exact),
                  scalar_condition("source", "solid", BcType::heat_source, source)},
                 {});
    run.run(exact, 1e6, 1); // steady
    const auto [error, size, slope] = problem_test::l2_error(run.d.mesh, run.theta(), 1, {exact}, 1);
    const double order = m == 0 ? 0 : std::log(before / error) / std::log(double(meshes[m]) / meshes[m - 1]);
    before = error;
    say(what, "cells along an edge", meshes[m], error / size, order);
    if (m == 0) continue;
    EXPECT_GE(order, shape->order() + 0.9) << what;
    EXPECT_LE(order, shape->order() + 1.2) << what;
  }
}

TEST(HeatEquation, ConvergesWithOrderTwoInSpaceAndThreeInCellsOfSecondOrder) {
  space_order(Shape::quad4, {8, 16, 32}, false, "quad4");
  space_order(Shape::tri3, {8, 16, 32}, false, "tri3");
  space_order(Shape::quad4, {8, 16, 32}, true, "quad4, rings");
  space_order(Shape::hex8, {4, 8, 16}, false, "hex8");
  space_order(Shape::tet4, {8, 12, 16}, false, "tet4");
  space_order(Shape::tri6, {8, 16, 32}, false, "tri6");
  space_order(Shape::tri6, {8, 16, 32}, true, "tri6, rings");
  space_order(Shape::tet10, {4, 6, 8}, false, "tet10");
  space_order(Shape::quad9, {8, 16, 32}, true, "quad9, rings");
  space_order(Shape::hex27, {3, 4, 6}, false, "hex27");
}

// theta = 300 + 50 sin(3 t) + x (1 + t): linear in space, so that only the steps err. Flux on all sides:
// kappa (1 + t) n_x, which convection to a temperature that fits takes over with h = 2.
TEST(HeatEquation, ConvergesInTimeWithTheOrderOfTheRule) {
  const MaterialParameters law = conductor();
  const Field exact = [](const double* x, double t) { return 300 + 50 * std::sin(3 * t) + x[0] * (1 + t); };
  const Field source = [&law](const double* x, double t) { return law.c_v * (150 * std::cos(3 * t) + x[0]); };
  const Field around = [&law, exact](const double* x, double t) {
    const double normal = x[0] == 0 ? -1 : x[0] == 1 ? 1 : 0;
    return exact(x, t) + law.conductivity * (1 + t) * normal / 2;
  };
  BoundaryCondition convection = scalar_condition("air", "boundary", BcType::convection, around);
  convection.coefficient = expression([](const double*, double) { return 2.0; });
  for (const HeatForm form : {HeatForm::entropy, HeatForm::energy})
    for (const double weight : {1.0, 0.5}) {
      double before = 0;
      for (const int steps : {16, 32, 64}) {
        HeatCase run(mesh_of(Shape::quad4, 4), false, law,
                     {convection, scalar_condition("source", "solid", BcType::heat_source, source)},
                     {.form = form, .theta = weight});
        run.run(exact, 1, steps);
        const auto [error, size, slope] = problem_test::l2_error(run.d.mesh, run.theta(), 1, {exact}, 1);
        const double order = before == 0 ? 0 : std::log2(before / error), reference = weight == 1 ? 1 : 2;
        say(form == HeatForm::entropy ? "entropy" : "energy",
            weight == 1 ? "Euler steps" : "trapezoidal steps", steps, error / size, order);
        if (before != 0) {
          EXPECT_GE(order, reference - 0.1);
          EXPECT_LE(order, reference + 0.15);
        }
        before = error;
      }
    }
}

} // namespace
} // namespace impact
