#include "simulation.hpp"
#include <fstream>
#include <gtest/gtest.h>
#include <impact/time/pass_shell.hpp>
#include <unistd.h>

namespace impact {

using time_test::Entries;
using time_test::entry;
using time_test::Equations;
using time_test::equations_of;
using time_test::Options;
using time_test::Simulation;

namespace {

/// Duffing oscillators whose stiffness is lowered by a scalar that is solved for in turns with the motion.
/// The TS's SNES is a shell (coupling_); its pass runs the SNES of the motion (motion_) and then updates the
/// scalar.
struct Staggered {
  Simulation simulation;
  Handle<SNES> motion;
  PassShell coupling;
  PetscReal softening = 0, softening_n = 0;                                            // trial, committed
  std::function<bool(const Attempt&)> inverted = [](const Attempt&) { return false; }; // on this rank
  std::vector<PetscReal> dts, times;
  std::vector<SNESConvergedReason> reasons; // of the shell, try by try

  Staggered() : simulation(equations(), 5) {
    const TS ts = simulation.ts;
    check(SNESCreate(PETSC_COMM_WORLD, motion.out()));
    check(SNESSetOptionsPrefix(motion, "motion_"));
    check(SNESSetFunction(motion, simulation.r, SNESTSFormFunction, ts));
    check(SNESSetJacobian(motion, simulation.J, simulation.J, SNESTSFormJacobian, ts));
    check(SNESSetTolerances(motion, 1e-12, 1e-13, 1e-15, 30, PETSC_DEFAULT));
    check(SNESSetFromOptions(motion));

    coupling.mailbox = &time_mailbox(ts);
    coupling.pass = [this](PetscInt, Vec u) { return pass(u); };
    check(SNESSetOptionsPrefix(simulation.snes(), "coupling_"));
    make_pass_shell(simulation.snes(), coupling);

    set_step_hooks(ts,
                   {.before_attempt = [this](TS, const Attempt&) { softening = softening_n; },
                    .accept = [this](TS, const Attempt&, Vec, Vec, Vec) { return note_reason(), Verdict{}; },
                    .on_reject = [this](TS, const Attempt&) { note_reason(); },
                    .on_accept =
                        [this](TS, const Attempt& attempt) {
                          softening_n = softening;
                          dts.push_back(attempt.dt);
                          times.push_back(attempt.t);
                        }});
    time_test::fill(simulation.u, [](PetscInt i) { return 1 + 0.1 * static_cast<PetscReal>(i); });
  }

  PassResult pass(Vec u) {
    check(SNESSolve(motion, nullptr, u));
    PassResult result;
    check(SNESGetConvergedReason(motion, &result.inner));
    if (result.inner < 0) return result;
    PetscReal reach = 0;
    check(VecNorm(u, NORM_INFINITY, &reach));
    const PetscReal updated = std::max(softening_n, 0.2 * reach);
    result.change = std::abs(updated - softening);
    softening = updated;
    return result;
  }

  Equations equations() {
    Equations duffing = equations_of({.cubic = 1});
    duffing.residual = [this, inner = duffing.residual](PetscReal t, Vec u, Vec v, Vec a, Vec r) {
      inner(t, u, v, a, r);
      check(VecAXPY(r, -softening, u));
      // One rank sees an inverted cell; the domain error is raised on all of them.
      const Attempt& attempt = current_attempt(simulation.ts);
      const bool fine = attempt.number == 0 || !inverted(attempt);
      if (!all_ranks_agree(PETSC_COMM_WORLD, fine)) check(SNESSetFunctionDomainError(motion));
    };
    duffing.jacobian = [this, inner = duffing.jacobian](Vec u, PetscReal shift_v, PetscReal shift_a, Mat J) {
      inner(u, shift_v, shift_a, J);
      check(MatShift(J, -softening));
    };
    return duffing;
  }

  void note_reason() {
    SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
    check(SNESGetConvergedReason(simulation.snes(), &reason));
    reasons.push_back(reason);
  }
};

const Entries iterated{{"-coupling_snes_max_it", "40"}, {"-coupling_snes_atol", "1e-13"}};

TEST(Coupling, DomainErrorOnOneRankCutsTheStepAndLeavesNoTrace) {
  const Options options(iterated);
  int rank = 0, size = 1;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  MPI_Comm_size(PETSC_COMM_WORLD, &size);

  Staggered cut;
  cut.inverted = [&](const Attempt& attempt) {
    return rank == size - 1 && attempt.t_n > 0.25 && attempt.t_n < 0.35 && attempt.dt > 0.03;
  };
  time_test::run(cut.simulation, 0.1, 1.5);
  EXPECT_EQ(cut.simulation.reason(), TS_CONVERGED_TIME);
  EXPECT_EQ(step_control_state(cut.simulation.ts).rejections, 2);
  EXPECT_EQ(std::count(cut.reasons.begin(), cut.reasons.end(), SNES_DIVERGED_INNER), 2);
  EXPECT_EQ(std::count(cut.reasons.begin(), cut.reasons.end(), SNES_CONVERGED_FNORM_ABS),
            static_cast<std::ptrdiff_t>(cut.dts.size()));
  EXPECT_NEAR(cut.dts[3], 0.025, 1e-14);
  EXPECT_NEAR(*std::max_element(cut.dts.begin() + 4, cut.dts.end()), 0.1, 1e-14); // regrown
  EXPECT_EQ(step_control_state(cut.simulation.ts).dt, 0.1);

  Staggered small; // the same steps without a failure
  set_exact_times(small.simulation.ts, cut.times);
  time_test::run(small.simulation, 0.1, 1.5);
  EXPECT_EQ(step_control_state(small.simulation.ts).rejections, 0);
  ASSERT_EQ(small.times, cut.times);
  for (PetscInt i = 0; i < 5; ++i) {
    EXPECT_NEAR(entry(small.simulation.u, i), entry(cut.simulation.u, i), 1e-12);
    EXPECT_NEAR(entry(small.simulation.v, i), entry(cut.simulation.v, i), 1e-12);
  }
  EXPECT_NEAR(small.softening_n, cut.softening_n, 1e-13);
  EXPECT_GT(cut.softening_n, 0.2);
}

TEST(Coupling, ARoughPassIsNotTheLastOne) {
  const Options options({{"-coupling_snes_max_it", "3"}, {"-coupling_snes_atol", "0.1"}});
  Staggered staggered;
  std::vector<PetscInt> numbers;
  staggered.coupling.pass = [&](PetscInt number, Vec) {
    numbers.push_back(number);
    return PassResult{.change = number == 1 ? 1. : 0.01, .rough = number == 2 || number == 3};
  };
  time_test::run(staggered.simulation, 0.1, 0.1);
  EXPECT_EQ(staggered.reasons, std::vector{SNES_CONVERGED_FNORM_ABS});
  EXPECT_EQ(numbers, (std::vector<PetscInt>{1, 2, 3, 4})); // the fourth beyond the limit
}

TEST(Coupling, RatesBelongToTheSolutionNotToTheLastEvaluation) {
  const Options options(iterated);
  Staggered plain, stray;
  stray.coupling.pass = [&, pass = stray.coupling.pass](PetscInt number, Vec u) {
    const PassResult result = pass(number, u);
    Handle<Vec> elsewhere, r;
    check(VecDuplicate(u, elsewhere.out()));
    check(VecDuplicate(u, r.out()));
    check(VecSet(elsewhere, 7));
    check(SNESComputeFunction(stray.motion, elsewhere, r));
    return result;
  };
  for (Staggered* staggered : {&plain, &stray}) time_test::run(staggered->simulation, 0.1, 0.5);
  EXPECT_EQ(entry(stray.simulation.u, 3), entry(plain.simulation.u, 3));
  EXPECT_EQ(entry(stray.simulation.v, 3), entry(plain.simulation.v, 3));
}

TEST(Coupling, FailureThatStaysEndsTheRun) {
  Staggered broken;
  broken.inverted = [](const Attempt& attempt) { return attempt.t > 0.25; };
  time_test::run(broken.simulation, 0.1, 1.5);
  EXPECT_EQ(broken.simulation.reason(), TS_DIVERGED_STEP_REJECTED);
  EXPECT_LE(broken.simulation.time(), 0.25);
  EXPECT_GE(broken.simulation.time(), 0.2 - 1e-12);
}

TEST(Coupling, SinglePassCountsAsConverged) {
  const Options options(Entries{{"-coupling_snes_max_it", "1"}});
  Staggered single;
  time_test::run(single.simulation, 0.1, 0.1);
  EXPECT_EQ(single.simulation.reason(), TS_CONVERGED_TIME);
  EXPECT_EQ(single.reasons, std::vector<SNESConvergedReason>{SNES_CONVERGED_ITS});
  EXPECT_GT(single.softening_n, 0.2);
}

TEST(Coupling, TooFewPassesCutTheStep) {
  const Options options(Entries{{"-coupling_snes_max_it", "2"}, {"-coupling_snes_atol", "1e-13"}});
  Staggered hasty;
  time_test::run(hasty.simulation, 0.1, 0.1);
  EXPECT_EQ(hasty.reasons.front(), SNES_DIVERGED_MAX_IT);
  EXPECT_GE(step_control_state(hasty.simulation.ts).rejections, 1);
}

TEST(Coupling, BothSolversAreSteeredFromTheCommandLine) {
  const std::string file = ::testing::TempDir() + "impact_coupling_" + std::to_string(getpid()) + ".txt";
  Entries entries = iterated;
  entries.emplace_back("-coupling_snes_monitor", "ascii:" + file);
  entries.emplace_back("-motion_snes_max_it", "17");
  const Options options(entries);
  PetscInt passes = 0;
  {
    Staggered staggered;
    staggered.coupling.pass = [&, pass = staggered.coupling.pass](PetscInt number, Vec u) {
      ++passes;
      return pass(number, u);
    };
    time_test::run(staggered.simulation, 0.1, 0.3);
    PetscInt most = 0;
    check(SNESGetTolerances(staggered.motion, nullptr, nullptr, nullptr, &most, nullptr));
    EXPECT_EQ(most, 17);
    EXPECT_GT(passes, 3);
  }
  int rank = 0;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  if (rank != 0) return;
  std::ifstream monitor(file);
  PetscInt lines = 0;
  for (std::string line; std::getline(monitor, line);)
    lines += line.find("SNES Function norm") != std::string::npos;
  EXPECT_EQ(lines, passes);
  std::remove(file.c_str());
}

} // namespace
} // namespace impact
