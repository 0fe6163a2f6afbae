#include "simulation.hpp"
#include <gtest/gtest.h>

namespace impact {

using time_test::entry;
using time_test::equations_of;
using time_test::run;
using time_test::Simulation;

namespace {

TEST(Static, FollowsTheEquilibriumPathWithoutInertia) {
  Simulation simulation(equations_of({.m = 1e6, .cubic = 1, .load = 2}), 3); // u + u^3 = 2 t
  check(TSSetType(simulation.ts, "static"));
  run(simulation, 0.25, 1);
  EXPECT_EQ(simulation.time(), 1);
  EXPECT_NEAR(entry(simulation.u, 1), 1, 1e-12);
}

TEST(Static, VelocityIsTheBackwardDifference) {
  Simulation simulation(equations_of({.m = 1e6, .c = 3, .load = 2}), 2); // 3 v + u = 2 t
  check(TSSetType(simulation.ts, "static"));
  run(simulation, 0.5, 1);
  const PetscReal first = 1.0 / 7, second = (6 * first + 2) / 7;
  EXPECT_NEAR(entry(simulation.u, 0), second, 1e-13);
  EXPECT_NEAR(entry(simulation.v, 1), (second - first) / 0.5, 1e-12);
  PetscInt iterations = 0;
  check(TSGetSNESIterations(simulation.ts, &iterations));
  EXPECT_EQ(iterations, 2); // linear: one per step
}

TEST(Static, CutsTheStepAndGrowsItAgain) {
  Simulation simulation(equations_of({.cubic = 1, .load = 2}), 3);
  check(TSSetType(simulation.ts, "static"));
  std::vector<PetscReal> dts;
  set_step_hooks(simulation.ts,
                 {.accept = [](TS, const Attempt& attempt, Vec, Vec,
                               Vec) { return Verdict{.accept = attempt.t_n > 0 || attempt.dt < 0.06}; },
                  .on_accept = [&](TS, const Attempt& attempt) { dts.push_back(attempt.dt); }});
  run(simulation, 0.1, 0.7);
  const std::vector<PetscReal> expected{.05, .05, .05, .05, .075, .075, .075, .075, .1, .1};
  ASSERT_EQ(dts.size(), expected.size());
  for (std::size_t i = 0; i < dts.size(); ++i) EXPECT_NEAR(dts[i], expected[i], 1e-12);
  const PetscReal u = entry(simulation.u, 2);
  EXPECT_NEAR(u + u * u * u, 1.4, 1e-11);
}

} // namespace
} // namespace impact
