#include "simulation.hpp"
#include <gtest/gtest.h>

namespace impact {

using time_test::Entries;
using time_test::entry;
using time_test::Equations;
using time_test::equations_of;
using time_test::Options;
using time_test::run;
using time_test::Simulation;

namespace {

/// Records the accepted steps; the residual is not a number wherever `fails` says so.
struct Watched {
  std::function<bool(const Attempt&, PetscInt step)> fails = [](const Attempt&, PetscInt) { return false; };
  std::vector<PetscReal> dts, times;
  PetscInt rejected = 0, tries = 0;
  Simulation simulation;

  Watched() : simulation(equations(), 3) {
    check(VecSet(simulation.u, 1));
    watch({});
  }

  void watch(StepHooks hooks) {
    hooks.before_attempt = [this](TS, const Attempt&) { ++tries; };
    hooks.on_reject = [this](TS, const Attempt&) { ++rejected; };
    hooks.on_accept = [this](TS, const Attempt& attempt) {
      dts.push_back(attempt.dt);
      times.push_back(attempt.t);
    };
    set_step_hooks(simulation.ts, std::move(hooks));
  }

  Equations equations() {
    Equations duffing = equations_of({.cubic = 1});
    duffing.residual = [this, inner = duffing.residual](PetscReal t, Vec u, Vec v, Vec a, Vec r) {
      inner(t, u, v, a, r);
      const Attempt& attempt = current_attempt(simulation.ts);
      PetscInt step = 0;
      check(TSGetStepNumber(simulation.ts, &step));
      if (attempt.number > 0 && fails(attempt, step))
        check(VecSet(r, std::numeric_limits<PetscReal>::quiet_NaN()));
    };
    return duffing;
  }
};

void expect_near(const std::vector<PetscReal>& given, const std::vector<PetscReal>& expected) {
  ASSERT_EQ(given.size(), expected.size());
  for (std::size_t i = 0; i < given.size(); ++i) EXPECT_NEAR(given[i], expected[i], 1e-12) << "step " << i;
}

TEST(StepControl, HitsGivenTimesExactlyAndRemembersTheStep) {
  Watched watched;
  set_exact_times(watched.simulation.ts, {0.77, 0.25, -1});
  run(watched.simulation, 0.1, 1.1 * 0.9);
  expect_near(watched.dts, {.1, .1, .05, .1, .1, .1, .1, .1, .02, .1, .1, .02});
  EXPECT_EQ(watched.times[2], 0.25);
  EXPECT_EQ(watched.times[8], 0.77);
  EXPECT_EQ(watched.times.back(), 1.1 * 0.9);
  EXPECT_EQ(watched.simulation.time(), 1.1 * 0.9);
  EXPECT_EQ(watched.simulation.reason(), TS_CONVERGED_TIME);
  EXPECT_EQ(step_control_state(watched.simulation.ts).dt, 0.1);
}

TEST(StepControl, LongStepEndsOnTheGivenTimeInSpiteOfRoundOff) {
  Watched watched;
  const PetscReal from = 0.12, to = 1.16;
  ASSERT_NE(from + (to - from), to);
  check(TSSetTime(watched.simulation.ts, from));
  run(watched.simulation, 10, to);
  EXPECT_EQ(watched.dts.size(), 1u);
  EXPECT_EQ(watched.simulation.time(), to);
}

TEST(StepControl, RoundOffInTheTimeMakesNoExtraStep) {
  Watched watched;
  run(watched.simulation, 1e-3, 0.3);
  EXPECT_EQ(watched.dts.size(), 300u);
  EXPECT_EQ(watched.simulation.time(), 0.3);
}

// (t<=0.3) is to hold in the third step.
TEST(StepControl, TimesOfDecimalStepsAreTheirDecimals) {
  for (const int steps : {10, 7}) {
    Watched watched;
    run(watched.simulation, 1. / steps, 1);
    ASSERT_EQ(watched.times.size(), static_cast<std::size_t>(steps));
    for (int n = 1; n <= steps; ++n) {
      const double sum = n / double(steps);
      if (steps == 10)
        EXPECT_EQ(watched.times[static_cast<std::size_t>(n - 1)], sum);
      else
        EXPECT_NEAR(watched.times[static_cast<std::size_t>(n - 1)], sum, 1e-15);
    }
  }
  Watched watched;
  run(watched.simulation, 0.005, 1);
  EXPECT_EQ(watched.times[99], 0.5);
}

TEST(StepControl, LeavesNoSliver) {
  Watched watched;
  set_exact_times(watched.simulation.ts, {1e-12, 0.205, 0.205 + 1e-12});
  run(watched.simulation, 0.1, 0.305 + 1e-12);
  expect_near(watched.dts, {.1, .0525, .0525, .1});
  EXPECT_EQ(watched.times[2], 0.205 + 1e-12);
}

TEST(StepControl, FollowsTheStepTable) {
  Watched watched;
  set_step_table(watched.simulation.ts, {0, 1, 2}, {0.5, 0.25});
  run(watched.simulation, 7, 2.5);
  expect_near(watched.dts, {.5, .5, .25, .25, .25, .25, .25, .25});
  EXPECT_EQ(watched.times[1], 1);
  EXPECT_EQ(watched.times[5], 2);
}

TEST(StepControl, HalvesAfterAFailureAndGrowsBack) {
  Watched watched;
  watched.fails = [](const Attempt& attempt, PetscInt step) { return step == 2 && attempt.dt > 0.06; };
  run(watched.simulation, 0.1, 1.2);
  expect_near(watched.dts, {.1, .1, .05, .05, .05, .05, .075, .075, .075, .075, .1, .1, .1, .1, .1});
  EXPECT_EQ(watched.rejected, 1);
  EXPECT_EQ(watched.tries, 16);
  EXPECT_EQ(step_control_state(watched.simulation.ts).rejections, 1);
  EXPECT_TRUE(step_control_state(watched.simulation.ts).at_limit);
}

TEST(StepControl, DoesNotGrowAfterHardSteps) {
  Watched watched;
  watched.watch({.effort = [](TS) { return PetscInt{11}; }});
  watched.fails = [](const Attempt& attempt, PetscInt step) { return step == 0 && attempt.dt > 0.06; };
  run(watched.simulation, 0.1, 0.5);
  expect_near(watched.dts, std::vector<PetscReal>(10, 0.05));
}

TEST(StepControl, CutsFromTheShortenedStepThatFailed) {
  Watched watched;
  set_exact_times(watched.simulation.ts, {0.04});
  watched.fails = [](const Attempt& attempt, PetscInt step) { return step == 0 && attempt.dt > 0.03; };
  run(watched.simulation, 0.1, 0.1);
  expect_near(watched.dts, {.02, .02, .02, .02, .02});
}

TEST(StepControl, GivesUpAfterTheAllowedTriesAndKeepsTheState) {
  const Options options(Entries{{"-ts_max_reject", "3"}});
  Watched watched;
  Simulation& simulation = watched.simulation;
  PetscReal u = 0, v = 0, a = 0;
  watched.fails = [](const Attempt&, PetscInt step) { return step == 2; };
  StepHooks hooks;
  hooks.guess = [&](TS ts, const Attempt&, Vec) {
    u = entry(simulation.u, 0);
    v = entry(simulation.v, 0);
    a = entry(acceleration(ts), 0);
  };
  watched.watch(std::move(hooks));
  run(simulation, 0.1, 1);
  EXPECT_EQ(simulation.reason(), TS_DIVERGED_STEP_REJECTED);
  EXPECT_EQ(watched.rejected, 4);
  EXPECT_EQ(watched.tries, 6);
  EXPECT_NEAR(simulation.time(), 0.2, 1e-15);
  EXPECT_EQ(entry(simulation.u, 0), u);
  EXPECT_EQ(entry(simulation.v, 0), v);
  EXPECT_EQ(entry(acceleration(simulation.ts), 0), a);
  EXPECT_NEAR(a, -(u + u * u * u), 1e-9); // the acceleration of t = 0.2, not of a failed try
}

TEST(StepControl, GivesUpBelowTheSmallestStep) {
  const Options options(Entries{{"-ts_adapt_dt_min", "0.02"}});
  Watched watched;
  watched.fails = [](const Attempt&, PetscInt) { return true; };
  run(watched.simulation, 0.1, 1);
  EXPECT_EQ(watched.simulation.reason(), TS_DIVERGED_STEP_REJECTED);
  EXPECT_EQ(watched.tries, 3);
}

TEST(StepControl, SecondCriterionRefusesOnAllRanksWhenOneDoes) {
  int rank = 0, size = 1;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  MPI_Comm_size(PETSC_COMM_WORLD, &size);
  Watched watched;
  watched.watch({.accept = [&](TS, const Attempt& attempt, Vec, Vec, Vec) {
    return Verdict{.accept = attempt.dt < 0.06 || rank != size - 1, .factor = 0.25};
  }});
  run(watched.simulation, 0.1, 0.1);
  expect_near(watched.dts, {.025, .025, .025, .025});
  EXPECT_EQ(watched.rejected, 1);
}

TEST(StepControl, ExceptionsOfHooksReachTheCaller) {
  Watched watched;
  watched.watch({.guess = [](TS, const Attempt& attempt, Vec) {
    if (attempt.t > 0.25) throw UserError(ExitCode::data, "probe");
  }});
  check(PetscPushErrorHandler(PetscIgnoreErrorHandler, nullptr));
  EXPECT_THROW(run(watched.simulation, 0.1, 1), UserError);
  check(PetscPopErrorHandler());
  EXPECT_EQ(watched.dts.size(), 2u);
}

TEST(StepControl, RestartInTheMiddleOfGrowthIsBitwise) {
  const auto fails = [](const Attempt& attempt, PetscInt step) { return step == 2 && attempt.dt > 0.03; };
  Watched whole, first, second;
  for (Watched* watched : {&whole, &first, &second}) {
    watched->fails = fails;
    set_exact_times(watched->simulation.ts, {0.325, 0.77});
  }
  run(whole.simulation, 0.1, 1.3);
  run(first.simulation, 0.1, 0.325); // 0.325 lies in the growth
  Simulation& from = first.simulation;
  Simulation& to = second.simulation;
  PetscInt steps = 0;
  check(TSGetStepNumber(from.ts, &steps));
  check(VecCopy(from.u, to.u));
  check(VecCopy(from.v, to.v));
  check(TSSetTime(to.ts, from.time()));
  check(TSSetStepNumber(to.ts, steps));
  set_acceleration(to.ts, acceleration(from.ts));
  EXPECT_FALSE(step_control_state(from.ts).at_limit);
  EXPECT_GT(step_control_state(from.ts).easy_steps, 0);
  set_step_control_state(to.ts, step_control_state(from.ts));
  run(to, 0.1, 1.3);
  std::vector<PetscReal> joined = first.times;
  joined.insert(joined.end(), second.times.begin(), second.times.end());
  EXPECT_EQ(joined, whole.times);
  EXPECT_EQ(entry(to.u, 1), entry(whole.simulation.u, 1));
  EXPECT_EQ(entry(to.v, 2), entry(whole.simulation.v, 2));
  EXPECT_EQ(step_control_state(to.ts).rejections, step_control_state(whole.simulation.ts).rejections);
}

TEST(StepControl, StepThatIsNotPositiveIsAUserError) {
  Watched watched;
  check(PetscPushErrorHandler(PetscIgnoreErrorHandler, nullptr));
  EXPECT_THROW(run(watched.simulation, -0.1, 1), UserError);
  check(PetscPopErrorHandler());
}

TEST(StepControl, AnotherAdaptTypeIsNamedInTheError) {
  const Options options(Entries{{"-ts_adapt_type", "none"}});
  Watched watched;
  run(watched.simulation, 0.1, 0.5 - 1e-9);
  EXPECT_EQ(watched.dts.size(), 5u);
  EXPECT_THROW(step_control_state(watched.simulation.ts), UserError);
}

} // namespace
} // namespace impact
