#include "step_data.hpp"

/// The implicit stage of a step: u_tilde = u_n + dt v_n, a first guess and the nonlinear solve for u, at
/// whose iterates v and a follow from (97-98).
namespace impact::detail {

namespace {

// Sets u_tilde and the first guess of trial.u.
void predict(TS ts, StepData& self) {
  const Attempt& step = self.attempt;
  Trial& trial = self.trial;
  if (!self.integrator.inertia) return check(VecCopy(ts->vec_sol, trial.u));
  check(VecWAXPY(trial.u_tilde, step.dt, ts->vec_dot, ts->vec_sol));
  check(VecCopy(ts->vec_dot, trial.v_start));
  if (self.hooks.predict) self.hooks.predict(ts, step, trial.u_tilde, trial.v_start);
  if (self.extrapolate)
    check(VecWAXPY(trial.u, step.dt * step.dt / 2, self.a, trial.u_tilde));
  else
    check(VecCopy(ts->vec_sol, trial.u));
}

} // namespace

void find_rates(TS ts, StepData& self, Vec u) {
  Trial& trial = self.trial;
  if (!self.integrator.inertia) {
    check(VecWAXPY(trial.v, -1, ts->vec_sol, u));
    return check(VecScale(trial.v, 1 / self.attempt.dt));
  }
  const auto [chi1, chi3, chi4, chi6] = self.integrator.coefficients(self.attempt.dt);
  const PetscReal alpha_m = self.integrator.alpha_m;
  check(VecWAXPY(trial.a, -1, trial.u_tilde, u));
  check(VecCopy(trial.v_start, trial.v));
  check(VecAXPBYPCZ(trial.v, chi4, chi6, 1, trial.a, self.a)); // (97)
  check(VecAXPBY(trial.a, -chi3, chi1, self.a));               // (98)
  check(VecCopy(trial.a, trial.a_m));
  if (alpha_m != 1) check(VecAXPBY(trial.a_m, 1 - alpha_m, alpha_m, self.a));
}

bool solve_stage(TS ts, StepData& self) {
  Vec u = self.trial.u;
  predict(ts, self);
  if (self.hooks.guess) self.hooks.guess(ts, self.attempt, u);
  check(TSPreStage(ts, self.attempt.t));
  check(SNESSolve(ts->snes, nullptr, u));
  PetscInt nonlinear = 0, linear = 0;
  check(SNESGetIterationNumber(ts->snes, &nonlinear));
  check(SNESGetLinearSolveIterations(ts->snes, &linear));
  ts->snes_its += nonlinear;
  ts->ksp_its += linear;
  check(TSPostStage(ts, self.attempt.t, 0, &u));
  PetscBool converged = PETSC_FALSE;
  check(TSAdaptCheckStage(ts->adapt, ts, self.attempt.t, u, &converged));
  return converged;
}

} // namespace impact::detail
