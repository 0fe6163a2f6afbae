#include "simulation.hpp"
#include <gtest/gtest.h>

namespace impact {

using time_test::Entries;
using time_test::entry;
using time_test::Options;
using time_test::Simulation;

namespace {

/// Elastic bar of unit length, modulus and density that flies against a wall at x = 0: u_0 >= 0, held exactly
/// by a bound of the variational inequality. Lumped mass, 40 cells; contact lasts two wave passages, t = 2.
struct Bar {
  static constexpr PetscInt cells = 40, size = cells + 1;
  static constexpr PetscReal h = 1.0 / cells;
  Handle<Mat> M, K;
  Handle<Vec> below, above, work;
  Simulation simulation;
  StepHooks hooks;
  PetscReal largest = 0, initial = 0, last = 0;

  Bar() : M(band(true)), K(band(false)), simulation(time_test::linear_equations(M, K), size) {
    check(VecDuplicate(simulation.u, below.out()));
    check(VecDuplicate(simulation.u, above.out()));
    check(VecDuplicate(simulation.u, work.out()));
    check(VecSet(above, PETSC_INFINITY));
    time_test::fill(below,
                    [](PetscInt i) { return i == 0 ? 0.0 : -std::numeric_limits<PetscReal>::infinity(); });
    check(VecSet(simulation.v, -1));
    check(SNESSetType(simulation.snes(), SNESVINEWTONRSLS));
    check(SNESVISetVariableBounds(simulation.snes(), below, above));
    initial = last = energy(simulation.u, simulation.v);
    hooks.on_accept = [this](TS, const Attempt&) {
      last = energy(simulation.u, simulation.v);
      largest = std::max(largest, last);
    };
    set_step_hooks(simulation.ts, hooks);
  }

  static Handle<Mat> band(bool mass) {
    Handle<Mat> A;
    check(MatCreateAIJ(PETSC_COMM_WORLD, PETSC_DECIDE, PETSC_DECIDE, size, size, 3, nullptr, 2, nullptr,
                       A.out()));
    PetscInt begin = 0, end = 0;
    check(MatGetOwnershipRange(A, &begin, &end));
    for (PetscInt i = begin; i < end; ++i)
      for (PetscInt j = std::max<PetscInt>(i - 1, 0); j <= std::min<PetscInt>(i + 1, cells); ++j) {
        const PetscReal sides = (i == 0 || i == cells) ? 1 : 2;
        const PetscReal value = mass ? (i == j ? sides * h / 2 : 0) : (i == j ? sides / h : -1 / h);
        check(MatSetValue(A, i, j, value, INSERT_VALUES));
      }
    check(MatAssemblyBegin(A, MAT_FINAL_ASSEMBLY));
    check(MatAssemblyEnd(A, MAT_FINAL_ASSEMBLY));
    return A;
  }

  PetscReal energy(Vec u, Vec v) {
    PetscReal kinetic = 0, elastic = 0;
    check(MatMult(M, v, work));
    check(VecDot(v, work, &kinetic));
    check(MatMult(K, u, work));
    check(VecDot(u, work, &elastic));
    return (kinetic + elastic) / 2;
  }

  /// Velocity projected so that the predictor has u_0 >= 0; the contact part of the acceleration is taken out
  /// and acts implicitly.
  void stabilise() {
    hooks.predict = [this](TS, const Attempt& attempt, Vec u, Vec v) {
      check(VecCopy(u, work));
      check(VecPointwiseMax(u, u, below));
      check(VecAYPX(work, -1, u));
      check(VecAXPY(v, 1 / attempt.dt, work));
    };
    hooks.correct = [this](TS ts, Vec u, Vec v, Vec a) {
      const Integrator& p = integrator_of(ts);
      Handle<Vec> force, a_m;
      check(VecDuplicate(a, force.out()));
      check(VecDuplicate(a, a_m.out()));
      check(VecCopy(a, a_m));
      check(VecAXPBY(a_m, 1 - p.alpha_m, p.alpha_m, acceleration(ts)));
      simulation.equations.residual(0, u, v, a_m, force);
      time_test::fill(work, [](PetscInt i) { return i == 0 ? 2 / h : 0.0; }); // 1/M at the contact
      check(VecPointwiseMult(force, force, work));
      check(VecAXPY(a, -1 / p.alpha_m, force));
      check(VecAXPY(v, current_attempt(ts).dt * (2 * p.beta - p.gamma) / p.alpha_m, force));
    };
    set_step_hooks(simulation.ts, hooks);
  }
};

TEST(ContactStabilisedNewmark, NeverRaisesTheEnergy) {
  for (const PetscReal ratio : {0.5, 1.0, 2.7}) {
    Bar bar;
    bar.stabilise();
    time_test::run(bar.simulation, ratio * Bar::h, 3);
    EXPECT_LE(bar.largest, bar.initial * (1 + 1e-10)) << "dt/h " << ratio;
    EXPECT_GT(bar.last, 0.9 * bar.initial) << "dt/h " << ratio;
    PetscReal momentum = 0;
    check(VecSum(bar.simulation.v, &momentum));
    EXPECT_GT(momentum / Bar::size, 0.9) << "the bar rebounds";
    EXPECT_LT(momentum / Bar::size, 1.05);
    EXPECT_GT(entry(bar.simulation.u, 0), 0);
  }
}

TEST(ContactStabilisedNewmark, PlainNewmarkWithTheSameConstraintGainsEnergy) {
  Bar bar;
  time_test::run(bar.simulation, 0.5 * Bar::h, 3);
  EXPECT_GT(bar.largest, 1.5 * bar.initial);
}

TEST(ContactStabilisedNewmark, DampedFamilyStaysBelowTheInitialEnergy) {
  const Options options(Entries{{"-ts_newmark_rho", "0.9"}});
  Bar bar;
  bar.stabilise();
  time_test::run(bar.simulation, 0.5 * Bar::h, 3);
  EXPECT_LE(bar.largest, bar.initial * (1 + 1e-10));
  EXPECT_GT(bar.last, 0.85 * bar.initial);
}

} // namespace
} // namespace impact
