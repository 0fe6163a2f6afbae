#include "../mesh/box_mesh.hpp"
#include "../time/simulation.hpp"
#include "own_integrator.hpp"
#include "simulation_case.hpp"
#include <gtest/gtest.h>

namespace impact {

using time_test::backward_euler;
using time_test::entry;
using time_test::equations_of;
using time_test::Simulation;

namespace {

TEST(OwnIntegrator, StepsLikeBackwardEuler) {
  constexpr PetscReal dt = 0.1, k = 3, v_0 = 2;
  Simulation simulation(equations_of({.k = k}), 2);
  check(VecSet(simulation.u, 1));
  check(VecSet(simulation.v, v_0));
  set_integrator(simulation.ts, backward_euler);
  time_test::run(simulation, dt, 3 * dt);
  PetscReal u = 1, v = v_0;
  for (int step = 0; step < 3; ++step) {
    v = (v - dt * k * u) / (1 + dt * dt * k);
    u += dt * v;
  }
  EXPECT_NEAR(entry(simulation.u, 0), u, 1e-13);
  EXPECT_NEAR(entry(simulation.v, 1), v, 1e-12);
  EXPECT_NEAR(entry(acceleration(simulation.ts), 1), -k * u, 1e-11);
}

TEST(OwnIntegrator, IsOfFirstOrderAndDamps) {
  PetscReal error[2] = {};
  for (int fine : {0, 1}) {
    Simulation simulation(equations_of({}), 1);
    check(VecSet(simulation.u, 1));
    set_integrator(simulation.ts, backward_euler);
    time_test::run(simulation, fine ? 0.005 : 0.01, 1);
    error[fine] = std::cos(1.0) - entry(simulation.u, 0);
  }
  EXPECT_NEAR(std::log2(error[0] / error[1]), 1, 0.05);
  EXPECT_TRUE(std::isinf(backward_euler.stability_limit()));
}

// The whole staggered step of the program with it: a bar at rest that a body force sets into motion.
TEST(OwnIntegrator, CarriesAStepOfTheProgram) {
  MaterialParameters law;
  law.K = 1e3;
  law.G = 6e2;
  law.rho = 2;
  problem_test::CaseSettings settings;
  settings.inertia = true;
  settings.integrator = backward_euler;
  settings.dt = 1e-3;
  settings.t_end = 2e-3;
  const problem_test::Field push = [](const double*, double) { return 5.0; };
  problem_test::MotionCase bar(
      run_test::mesh_of(PETSC_COMM_WORLD, run_test::fresh_dir("own_integrator"),
                        run_test::box_mesh(Shape::quad4, 2)),
      law, {problem_test::condition("load", "solid", BcType::body_force, {push, push})}, settings);
  bar.run();
  // No support: all points move alike, v = 5 t and u = dt sum of v.
  for (double u : bar.u()) EXPECT_NEAR(u, 1e-3 * 5 * (1e-3 + 2e-3), 1e-12);
}

// The roots of the oscillator's characteristic polynomial leave the unit circle where the limit says so.
TEST(Integrator, StabilityLimitIsThatOfTheOscillator) {
  EXPECT_TRUE(std::isinf(newmark_with_radius(0.5).stability_limit()));
  for (const Integrator& scheme :
       {Integrator{.beta = 0.1, .gamma = 0.5}, Integrator{.beta = 0.2, .gamma = 0.6},
        Integrator{.beta = 0.25, .gamma = 0.6, .alpha_m = 1.1}}) {
    const PetscReal limit = scheme.stability_limit();
    ASSERT_TRUE(std::isfinite(limit));
    for (const PetscReal part : {0.98, 1.02}) {
      Simulation simulation(equations_of({.k = part * part * limit * limit}), 1); // dt = 1
      check(VecSet(simulation.u, 1e-3));
      set_integrator(simulation.ts, scheme);
      time_test::run(simulation, 1, 400);
      EXPECT_EQ(std::abs(entry(simulation.u, 0)) < 1, part < 1) << scheme.beta << " " << part;
    }
  }
}

} // namespace
} // namespace impact
