#include "simulation.hpp"
#include <gtest/gtest.h>
#ifdef __SANITIZE_ADDRESS__
#include <sanitizer/lsan_interface.h>
#endif

namespace impact {

using time_test::Entries;
using time_test::entry;
using time_test::equations_of;
using time_test::Options;
using time_test::Oscillator;
using time_test::run;
using time_test::Simulation;

namespace {

constexpr Oscillator duffing{.k = 1, .cubic = 1};
// u(2) and v(2) of u'' + u + u^3 = 0, u(0) = 1: cn and -sqrt(2) sn dn of (2 sqrt(2) | 1/4).
constexpr PetscReal duffing_u = -0.8593493581018551, duffing_v = -0.6991719039510226;

struct Errors {
  PetscReal u, v;
};

Errors duffing_error(PetscReal dt) {
  Simulation simulation(equations_of(duffing), 1);
  check(VecSet(simulation.u, 1));
  run(simulation, dt, 2);
  return {std::abs(entry(simulation.u, 0) - duffing_u), std::abs(entry(simulation.v, 0) - duffing_v)};
}

TEST(Newmark, IsSecondOrderForEverySpectralRadius) {
  for (const char* rho : {"1", "0.8", "0.5", "0"}) {
    const Options options(Entries{{"-ts_newmark_rho", rho}});
    const Errors coarse = duffing_error(0.025), fine = duffing_error(0.0125);
    EXPECT_NEAR(std::log2(coarse.u / fine.u), 2, 0.06) << "rho " << rho;
    EXPECT_NEAR(std::log2(coarse.v / fine.v), 2, 0.06) << "rho " << rho;
  }
}

TEST(Newmark, IsFirstOrderWithGammaAboveOneHalf) {
  const Options options(Entries{{"-ts_newmark_gamma", "0.7"}, {"-ts_newmark_beta", "0.36"}});
  EXPECT_NEAR(std::log2(duffing_error(0.0125).u / duffing_error(0.00625).u), 1, 0.1);
}

TEST(Newmark, ReproducesTheChiFormOracle) {
  Simulation simulation(equations_of({.k = 100}), 3);
  check(VecSet(simulation.u, 1));
  run(simulation, 0.05, 0.5);
  EXPECT_NEAR(entry(simulation.u, 2), 0.1860931031177, 1e-11);
  EXPECT_NEAR(entry(simulation.v, 2), 9.825321149825, 1e-9);
}

// The trapezoid turns (omega u, v) by a constant angle per step; the phase is gathered step by step.
PetscReal period_elongation(PetscReal omega_dt) {
  Simulation simulation(equations_of({}), 1);
  check(VecSet(simulation.u, 1));
  PetscReal phase = 0, last = 0;
  set_step_hooks(simulation.ts, {.on_accept = [&](TS, const Attempt&) {
                   const PetscReal now = std::atan2(-entry(simulation.v, 0), entry(simulation.u, 0));
                   phase += std::remainder(now - last, 2 * PETSC_PI);
                   last = now;
                 }});
  run(simulation, omega_dt, 200 * omega_dt);
  return 200 * omega_dt / phase;
}

TEST(Newmark, TrapezoidElongatesThePeriodAsTheoryPredicts) {
  EXPECT_NEAR(period_elongation(0.1), 1.00083278, 1e-8);
  EXPECT_NEAR(period_elongation(0.2), 1.00332449, 1e-8);
  EXPECT_NEAR(period_elongation(0.4), 1.01319402, 1e-8);
}

PetscReal energy_ratio_after(PetscReal dt, PetscInt steps) {
  Simulation simulation(equations_of({.k = 100}), 2);
  check(VecSet(simulation.u, 1));
  run(simulation, dt, dt * static_cast<PetscReal>(steps));
  const PetscReal u = entry(simulation.u, 1), v = entry(simulation.v, 1);
  return (v * v + 100 * u * u) / 100;
}

TEST(Newmark, TrapezoidKeepsTheEnergyOfALinearOscillator) {
  EXPECT_NEAR(energy_ratio_after(0.05, 2000), 1, 1e-10);
}

TEST(Newmark, DampedFamilyRemovesHighFrequencies) {
  const Options options(Entries{{"-ts_newmark_rho", "0.5"}});
  EXPECT_LT(energy_ratio_after(1000, 60), 1e-12);     // omega dt = 1e4
  EXPECT_GT(energy_ratio_after(0.001, 1000), 0.9999); // omega dt = 0.01
}

TEST(Newmark, RadiusGivesTheDampedFamily) {
  const Integrator p = newmark_with_radius(0.8);
  EXPECT_NEAR(p.alpha_m, 1.11111, 5e-6);
  EXPECT_NEAR(p.gamma, 0.61111, 5e-6);
  EXPECT_NEAR(p.beta, 0.308642, 5e-7);
  const Integrator paper = newmark_with_radius(1);
  EXPECT_EQ(paper.alpha_m, 1);
  EXPECT_EQ(paper.gamma, 0.5);
  EXPECT_EQ(paper.beta, 0.25);
}

TEST(Newmark, CoefficientsAreThePapers) {
  const Integrator::Coefficients chi = Integrator{.beta = 0.3, .gamma = 0.6}.coefficients(0.1);
  EXPECT_NEAR(chi.chi1, 1 / (0.3 * 0.01), 1e-10);
  EXPECT_NEAR(chi.chi3, (1 - 2 * 0.3) / (2 * 0.3), 1e-14);
  EXPECT_NEAR(chi.chi4, 0.6 / (0.3 * 0.1), 1e-11);
  EXPECT_NEAR(chi.chi6, (1 - 0.6 / (2 * 0.3)) * 0.1, 1e-14);
}

TEST(Newmark, OptionsOutOfRangeAreUserErrors) {
  const std::vector<Entries> wrong = {{{"-ts_newmark_rho", "1.5"}},
                                      {{"-ts_newmark_rho", "-0.1"}},
                                      {{"-ts_newmark_beta", "0"}},
                                      {{"-ts_newmark_gamma", "0.4"}},
                                      {{"-ts_newmark_rho", "0.8"}, {"-ts_newmark_beta", "0.3"}},
                                      {{"-ts_adapt_grow", "0.5"}}};
  for (const auto& entries : wrong) {
    const Options options(entries);
    Simulation simulation(equations_of({}), 1);
    check(PetscPushErrorHandler(PetscIgnoreErrorHandler, nullptr));
#ifdef __SANITIZE_ADDRESS__
    const __lsan::ScopedDisabler lost; // PETSc keeps the texts of a block of options that an error ends
#endif
    try {
      set_time_options(simulation.ts);
      ADD_FAILURE() << entries[0].first << " " << entries[0].second << " was accepted";
    } catch (const UserError& error) {
      EXPECT_EQ(error.code(), ExitCode::usage);
      EXPECT_NE(std::string(error.what()).find("allowed:"), std::string::npos) << error.what();
    }
    check(PetscPopErrorHandler());
  }
}

TEST(Newmark, OptionsFollowThePrefixOfTheTS) {
  const Options options(Entries{{"-beam_ts_newmark_rho", "0.8"}, {"-ts_newmark_rho", "0.5"}});
  Simulation simulation(equations_of({}), 1);
  check(TSSetOptionsPrefix(simulation.ts, "beam_"));
  set_time_options(simulation.ts);
  EXPECT_NEAR(integrator_of(simulation.ts).alpha_m, 2 / 1.8, 1e-15);
}

// Consistent mass h/6 [4 1; 1 4], stiffness 1/h [2 -1; -1 2], first row held.
struct Chain {
  static constexpr PetscInt size = 7;
  Handle<Mat> M, K;

  Chain() {
    for (Handle<Mat>* matrix : {&M, &K})
      check(MatCreateAIJ(PETSC_COMM_WORLD, PETSC_DECIDE, PETSC_DECIDE, size, size, 3, nullptr, 2, nullptr,
                         matrix->out()));
    PetscInt begin = 0, end = 0;
    check(MatGetOwnershipRange(M, &begin, &end));
    for (PetscInt i = begin; i < end; ++i)
      for (PetscInt j = std::max<PetscInt>(i - 1, 0); j <= std::min<PetscInt>(i + 1, size - 1); ++j) {
        check(MatSetValue(M, i, j, i == 0 ? 0 : (i == j ? 4.0 : 1.0) / 6, INSERT_VALUES));
        check(MatSetValue(K, i, j, i == 0 ? (i == j ? 1 : 0) : 1e6 * (i == j ? 2 : -1), INSERT_VALUES));
      }
    for (Handle<Mat>* matrix : {&M, &K}) {
      check(MatAssemblyBegin(*matrix, MAT_FINAL_ASSEMBLY));
      check(MatAssemblyEnd(*matrix, MAT_FINAL_ASSEMBLY));
    }
  }
};

TEST(Newmark, InitialAccelerationBalancesTheForcesAtTheStart) {
  const Chain chain;
  Simulation simulation(time_test::linear_equations(chain.M, chain.K), Chain::size);
  time_test::fill(simulation.u,
                  [](PetscInt i) { return i == 0 ? 0.0 : 1e-3 * std::sin(1.3 * static_cast<double>(i)); });
  Handle<Vec> u0;
  check(VecDuplicate(simulation.u, u0.out()));
  check(VecCopy(simulation.u, u0));
  EXPECT_EQ(acceleration(simulation.ts), nullptr);
  PetscReal unbalanced = -1, force = 0, held = -1;
  set_step_hooks(simulation.ts, {.guess = [&](TS ts, const Attempt&, Vec) {
                   Handle<Vec> r;
                   check(VecDuplicate(u0, r.out()));
                   check(MatMult(chain.K, u0, r));
                   check(VecNorm(r, NORM_2, &force));
                   check(MatMultAdd(chain.M, acceleration(ts), r, r));
                   check(VecNorm(r, NORM_2, &unbalanced));
                   held = entry(acceleration(ts), 0);
                 }});
  run(simulation, 1e-3, 1e-3);
  EXPECT_GT(force, 1e2);
  EXPECT_GE(unbalanced, 0);
  EXPECT_LT(unbalanced, 1e-11 * force);
  EXPECT_EQ(held, 0);
}

TEST(Newmark, AccelerationThatWasSetIsNotComputedAgain) {
  Simulation simulation(equations_of({}), 2);
  check(VecSet(simulation.u, 1));
  Handle<Vec> a;
  check(VecDuplicate(simulation.u, a.out()));
  check(VecSet(a, 3));
  set_acceleration(simulation.ts, a);
  run(simulation, 0.1, 0.1);
  // One step of the trapezoid for u'' = -u from u = 1, v = 0, a = 3.
  const PetscReal u = (1 + 0.25 * 0.01 * 3) / (1 + 0.25 * 0.01);
  EXPECT_NEAR(entry(simulation.u, 0), u, 1e-13);
  EXPECT_NEAR(entry(simulation.v, 1), 0.05 * (3 - u), 1e-13);
  EXPECT_NEAR(entry(acceleration(simulation.ts), 1), -u, 1e-11);
}

TEST(Newmark, GuessIsExtrapolatedOrThePreviousState) {
  for (const char* kind : {"extrapolated", "previous"}) {
    const Options options(Entries{{"-ts_newmark_guess", kind}});
    Simulation simulation(equations_of({}), 2);
    check(VecSet(simulation.u, 1));
    check(VecSet(simulation.v, 3));
    PetscReal guess = 0;
    set_step_hooks(simulation.ts, {.guess = [&](TS, const Attempt&, Vec u) { guess = entry(u, 0); }});
    run(simulation, 0.1, 0.1);
    EXPECT_NEAR(guess, kind[0] == 'p' ? 1 : 1 + 0.1 * 3 - 0.005, 1e-14);
  }
}

TEST(Newmark, HooksChangeThePredictorAndTheRates) {
  Simulation simulation(equations_of({.k = 0}), 2); // a = 0 at the new time
  check(VecSet(simulation.u, 1));
  check(VecSet(simulation.v, 2));
  Handle<Vec> a;
  check(VecDuplicate(simulation.u, a.out()));
  check(VecSet(a, 3));
  set_acceleration(simulation.ts, a);
  const PetscReal dt = 0.1, shift = 0.5, predicted = 1 + 2 * dt + shift;
  set_step_hooks(simulation.ts, {.predict =
                                     [&](TS, const Attempt& attempt, Vec u, Vec v) {
                                       EXPECT_EQ(attempt.t_n, 0);
                                       EXPECT_EQ(attempt.dt, dt);
                                       EXPECT_NEAR(entry(u, 1), predicted - shift, 1e-15);
                                       check(VecShift(u, shift));
                                       check(VecShift(v, 0.25));
                                     },
                                 .correct =
                                     [&](TS, Vec, Vec v, Vec trial) {
                                       EXPECT_NEAR(entry(v, 0), 2.25 + 3 * dt / 2, 1e-12);
                                       EXPECT_NEAR(entry(trial, 0), 0, 1e-11);
                                       check(VecShift(v, -1));
                                       check(VecShift(trial, 7));
                                     }});
  run(simulation, dt, dt);
  EXPECT_NEAR(entry(simulation.u, 0), predicted + dt * dt / 4 * 3, 1e-13);
  EXPECT_NEAR(entry(simulation.v, 1), 1.25 + 3 * dt / 2, 1e-12);
  EXPECT_NEAR(entry(acceleration(simulation.ts), 1), 7, 1e-11);
}

TEST(Newmark, LinearDampedOscillatorTakesOneIterationPerStep) {
  for (const char* rho : {"1", "0.6"}) {
    const Options options(Entries{{"-ts_newmark_rho", rho}, {"-snes_rtol", "1e-9"}});
    Simulation simulation(equations_of({.c = 30, .k = 100}), 2);
    check(VecSet(simulation.u, 1));
    run(simulation, 0.05, 0.5);
    PetscInt iterations = 0;
    check(TSGetSNESIterations(simulation.ts, &iterations));
    EXPECT_EQ(iterations, 10) << "rho " << rho;
  }
}

// alpha2 estimates the initial acceleration from two half steps and, up to PETSc 3.21, finds twice the right
// value.
PetscReal distance_to_alpha2(PetscReal u0, PetscReal v0, PetscReal dt) {
  const Options options(Entries{{"-ts_alpha_alpha_m", "1"},
                                {"-ts_alpha_alpha_f", "1"},
                                {"-ts_alpha_gamma", "0.5"},
                                {"-ts_alpha_beta", "0.25"}});
  PetscReal u[2] = {};
  for (const bool oracle : {false, true}) {
    Simulation simulation(equations_of(duffing), 1);
    if (oracle) {
      check(TSSetType(simulation.ts, TSALPHA2));
      check(TSSetExactFinalTime(simulation.ts, TS_EXACTFINALTIME_STEPOVER));
    }
    check(VecSet(simulation.u, u0));
    check(VecSet(simulation.v, v0));
    check(TSSetTimeStep(simulation.ts, dt));
    check(TSSetMaxTime(simulation.ts, 100));
    check(TSSetMaxSteps(simulation.ts, static_cast<PetscInt>(std::lround(2 / dt))));
    set_time_options(simulation.ts);
    if (!oracle) time_test::start(simulation);
    solve_in_time(simulation.ts);
    EXPECT_NEAR(simulation.time(), 2, 1e-12);
    u[oracle] = entry(simulation.u, 0);
  }
  return std::abs(u[0] - u[1]);
}

TEST(Newmark, AgreesWithAlpha2UpToItsStart) {
  const PetscReal coarse = distance_to_alpha2(0, 1, 0.02), fine = distance_to_alpha2(0, 1, 0.01);
  EXPECT_LT(fine, 1e-4);
  EXPECT_GT(std::log2(coarse / fine), 1.8);
}

TEST(Newmark, RestartIsBitwise) {
  const Options options(Entries{{"-ts_newmark_rho", "0.8"}});
  Simulation whole(equations_of(duffing), 3), first(equations_of(duffing), 3),
      second(equations_of(duffing), 3);
  check(VecSet(whole.u, 1));
  check(VecSet(first.u, 1));
  run(whole, 0.0537, 40 * 0.0537);
  check(TSSetMaxSteps(first.ts, 17));
  check(TSSetMaxTime(first.ts, 40 * 0.0537));
  check(TSSetTimeStep(first.ts, 0.0537));
  set_time_options(first.ts);
  time_test::start(first);
  solve_in_time(first.ts);
  EXPECT_EQ(first.reason(), TS_CONVERGED_ITS);

  check(VecCopy(first.u, second.u));
  check(VecCopy(first.v, second.v));
  check(TSSetTime(second.ts, first.time()));
  check(TSSetStepNumber(second.ts, 17));
  set_acceleration(second.ts, acceleration(first.ts));
  set_step_control_state(second.ts, step_control_state(first.ts));
  run(second, 0.0537, 40 * 0.0537);

  EXPECT_EQ(second.time(), whole.time());
  EXPECT_EQ(entry(second.u, 0), entry(whole.u, 0));
  EXPECT_EQ(entry(second.v, 1), entry(whole.v, 1));
  EXPECT_EQ(entry(acceleration(second.ts), 2), entry(acceleration(whole.ts), 2));
  EXPECT_LT(entry(whole.u, 0), 1); // it moved
}

} // namespace
} // namespace impact
