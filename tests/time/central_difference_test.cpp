#include "simulation.hpp"
#include <gtest/gtest.h>

namespace impact {

using time_test::Entries;
using time_test::entry;
using time_test::equations_of;
using time_test::Options;
using time_test::Oscillator;
using time_test::Simulation;

namespace {

/// Oscillators by central differences: what the TS's SNES does is to divide the forces at u by the mass.
struct Explicit {
  Simulation simulation;
  Oscillator oscillator;
  int solves = 0;
  PetscReal moved = 0; ///< by the solves, which are to leave u as it is

  explicit Explicit(const Oscillator& given, PetscInt size = 1)
      : simulation(equations_of(given), size), oscillator(given) {
    check(TSSetType(simulation.ts, "central_difference"));
    check(SNESSetType(simulation.snes(), SNESSHELL));
    check(SNESShellSetContext(simulation.snes(), this));
    check(SNESShellSetSolve(simulation.snes(), [](SNES snes, Vec u) -> PetscErrorCode {
      void* context = nullptr;
      check(SNESShellGetContext(snes, &context));
      auto& self = *static_cast<Explicit*>(context);
      return self.simulation.mailbox.guarded([&] {
        self.accelerate(u);
        check(SNESSetConvergedReason(snes, SNES_CONVERGED_ITS));
      });
    }));
  }

  // The force of the residual with a = 0; the damping reads the velocity at the start of the step.
  void accelerate(Vec u) {
    const TS ts = simulation.ts;
    ++solves;
    Vec u_n = nullptr, v_n = nullptr;
    check(TS2GetSolution(ts, &u_n, &v_n));
    Handle<Vec> known, a;
    check(VecDuplicate(u, known.out()));
    check(VecDuplicate(u, a.out()));
    const Attempt& attempt = current_attempt(ts);
    // As the type finds u, to the last digit: VecAXPY may round otherwise, with fused products of a BLAS.
    check(VecWAXPY(a, attempt.dt, start_velocity(ts), u_n));
    check(VecWAXPY(known, attempt.dt * attempt.dt / 2, acceleration(ts), a));
    check(VecZeroEntries(a));
    check(VecAXPY(known, -1, u));
    PetscReal gap = 0;
    check(VecNorm(known, NORM_INFINITY, &gap));
    moved = std::max(moved, gap);
    simulation.equations.residual(attempt.t, u, start_velocity(ts), a, new_acceleration(ts));
    check(VecScale(new_acceleration(ts), -1 / oscillator.m));
  }

  PetscReal u(PetscInt i = 0) const { return entry(simulation.u, i); }
  PetscReal v(PetscInt i = 0) const { return entry(simulation.v, i); }
  PetscReal a(PetscInt i = 0) const { return entry(acceleration(simulation.ts), i); }
};

constexpr Oscillator duffing{.k = 1, .cubic = 1};
// u(2) and v(2) of u'' + u + u^3 = 0, u(0) = 1, as in newmark_test.cpp
constexpr PetscReal duffing_u = -0.8593493581018551, duffing_v = -0.6991719039510226;

struct Errors {
  PetscReal u, v;
};

Errors duffing_error(PetscReal dt) {
  Explicit run(duffing);
  check(VecSet(run.simulation.u, 1));
  time_test::run(run.simulation, dt, 2);
  EXPECT_EQ(run.moved, 0);
  return {std::abs(run.u() - duffing_u), std::abs(run.v() - duffing_v)};
}

TEST(CentralDifference, IsSecondOrder) {
  const Errors coarse = duffing_error(0.025), fine = duffing_error(0.0125);
  EXPECT_NEAR(std::log2(coarse.u / fine.u), 2, 0.02);
  EXPECT_NEAR(std::log2(coarse.v / fine.v), 2, 0.02);
}

TEST(CentralDifference, SolvesOnceInAStep) {
  Explicit run(duffing, 4);
  check(VecSet(run.simulation.u, 1));
  time_test::run(run.simulation, 0.1, 5);
  EXPECT_EQ(run.solves, 50);
}

// cos(omega t) at the frequency of the scheme, sin(omega_h dt/2) = omega dt/2.
TEST(CentralDifference, HasTheFrequencyOfTheoryAndKeepsTheAmplitude) {
  for (const PetscReal omega_dt : {0.1, 0.5, 1.0, 1.9}) {
    Explicit run({});
    check(VecSet(run.simulation.u, 1));
    PetscReal error = 0, speed_error = 0;
    const PetscReal turn = 2 * std::asin(omega_dt / 2);
    int step = 0;
    set_step_hooks(run.simulation.ts, {.on_accept = [&](TS, const Attempt&) {
                     const PetscReal angle = ++step * turn;
                     error = std::max(error, std::abs(run.u() - std::cos(angle)));
                     // v is the mean of the half steps' velocities
                     const PetscReal v = (std::cos(angle + turn) - std::cos(angle - turn)) / (2 * omega_dt);
                     speed_error = std::max(speed_error, std::abs(run.v() - v));
                   }});
    time_test::run(run.simulation, omega_dt, 10000 * omega_dt);
    EXPECT_EQ(step, 10000);
    EXPECT_LT(error, 1e-9) << omega_dt;
    EXPECT_LT(speed_error, 1e-9) << omega_dt;
  }
}

// At omega dt = 2 the oscillator turns over in each step and comes back; beyond it grows by the larger root.
TEST(CentralDifference, IsStableUpToTwo) {
  for (const PetscReal omega_dt : {2.0, 2.02}) {
    Explicit run({});
    check(VecSet(run.simulation.u, 1));
    time_test::run(run.simulation, omega_dt, 40 * omega_dt);
    const PetscReal half = omega_dt * omega_dt / 2 - 1, root = half + std::sqrt(half * half - 1 + 1e-300);
    EXPECT_NEAR(run.u() / ((std::pow(root, 40) + std::pow(root, -40)) / 2), 1, 1e-10) << omega_dt;
  }
}

TEST(CentralDifference, KeepsItsOwnEnergyToRounding) {
  constexpr PetscReal mass = 2, k = 3, dt = 0.875; // a binary number: times are exact
  Explicit run({.m = mass, .k = k}, 3);
  time_test::fill(run.simulation.u, [](PetscInt i) { return 1 - 0.4 * static_cast<PetscReal>(i); });
  time_test::fill(run.simulation.v, [](PetscInt i) { return 0.3 * static_cast<PetscReal>(i); });
  PetscReal first = 0, largest = 0, plain = 0;
  const auto energy = [&](bool own) {
    PetscReal sum = 0;
    for (PetscInt i = 0; i < 3; ++i)
      sum += mass * run.v(i) * run.v(i) / 2 + k * run.u(i) * run.u(i) / 2 -
             (own ? dt * dt / 8 * mass * run.a(i) * run.a(i) : 0);
    return sum;
  };
  set_step_hooks(run.simulation.ts, {.on_accept = [&](TS, const Attempt&) {
                   if (first == 0) first = energy(true);
                   largest = std::max(largest, std::abs(energy(true) - first));
                   plain = std::max(plain, std::abs(energy(false) - first));
                 }});
  time_test::run(run.simulation, dt, 5000 * dt);
  EXPECT_LT(largest, 1e-12 * first);
  EXPECT_GT(plain, 0.1 * first); // what the term -dt^2/8 a M a is for
}

/// No step is longer than the limit as it stands before the step.
TEST(CentralDifference, StepsObeyTheHookLongest) {
  Explicit run({}, 2);
  check(VecSet(run.simulation.u, 1));
  std::vector<PetscReal> dts;
  const auto limit = [&] { return dts.size() < 3 ? 0.08 : dts.size() < 6 ? 0.05 : 0.2; };
  int asked = 0;
  set_step_hooks(run.simulation.ts, {.longest =
                                         [&](TS) {
                                           ++asked;
                                           return limit();
                                         },
                                     .on_accept = [&](TS, const Attempt& a) { dts.push_back(a.dt); }});
  time_test::run(run.simulation, 0.1, 0.79);
  const std::vector<PetscReal> expected{.08, .08, .08, .05, .05, .05, .1, .1, .1, .1};
  ASSERT_EQ(dts.size(), expected.size());
  for (std::size_t i = 0; i < dts.size(); ++i) EXPECT_NEAR(dts[i], expected[i], 1e-12) << i;
  EXPECT_EQ(asked, 10);
}

// The limit itself is no cut: only the try that was refused waits for easy steps.
TEST(CentralDifference, AStepAfterACutGrowsBackBelowTheLimit) {
  Explicit run({}, 2);
  check(VecSet(run.simulation.u, 1));
  std::vector<PetscReal> dts;
  int tries = 0;
  set_step_hooks(run.simulation.ts,
                 {.longest = [](TS) { return 0.06; },
                  .accept = [&](TS, const Attempt&, Vec, Vec,
                                Vec) { return Verdict{.accept = ++tries != 2, .factor = 0.5}; },
                  .on_accept = [&](TS, const Attempt& a) { dts.push_back(a.dt); }});
  time_test::run(run.simulation, 0.1, 0.6);
  EXPECT_EQ(dts[0], 0.06);
  EXPECT_EQ(dts[1], 0.03);
  ASSERT_EQ(dts.size(), 13u);
  EXPECT_NEAR(dts[5], 0.045, 1e-15); // after 4 easy steps times 1.5
  for (std::size_t i = 9; i < dts.size(); ++i) EXPECT_NEAR(dts[i], 0.06, 1e-15);
}

TEST(CentralDifference, WeightsOfNewmarkStayWhatTheyAre) {
  const Options options(Entries{{"-ts_newmark_rho", "0.5"}});
  Explicit run({}, 1);
  check(VecSet(run.simulation.u, 1));
  time_test::run(run.simulation, 0.1, 0.2);
  const Integrator& weights = integrator_of(run.simulation.ts);
  EXPECT_EQ(weights.beta, 0);
  EXPECT_EQ(weights.gamma, 0.5);
  EXPECT_TRUE(weights.is_explicit());
  EXPECT_EQ(weights.mass_shift(0.1), 0);
  EXPECT_EQ(weights.share(), 1);
  EXPECT_EQ(weights.stability_limit(), 2);
}

} // namespace
} // namespace impact
