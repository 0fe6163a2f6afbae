#include "nodal_rate.hpp"
#include <impact/petsc/error.hpp>
#include <impact/petsc/field_solver.hpp>
#include <impact/problem/damage.hpp>
#include <petscts.h>

namespace impact {

// Callbacks whose context is the application's, not an argument.
template <void (DamageProblem::*method)(TS)> PetscErrorCode DamageProblem::call(TS ts) {
  DamageProblem* self = nullptr;
  if (const PetscErrorCode code = TSGetApplicationContext(ts, &self); code != 0) return code;
  return self->mailbox_.guarded([&] { (self->*method)(ts); });
}

void DamageProblem::make_substeps() {
  if (settings_.substep == 0 && settings_.explicit_substeps == 0) return;
  if (settings_.form != DamageForm::multiplied || settings_.theta != 1)
    throw UserError(ExitCode::usage,
                    "-damage_ts_dt: sub-steps want -damage_form multiplied and -damage_theta 1; the "
                    "theta of the sub-steps is -damage_ts_theta_theta");
  check(TSCreate(d_.mesh.comm(), substeps_.out()));
  check(TSSetOptionsPrefix(substeps_, "damage_"));
  check(TSSetProblemType(substeps_, TS_NONLINEAR));
  check(TSSetApplicationContext(substeps_, this));
  check(TSSetPreStep(substeps_, call<&DamageProblem::start_substep>));
  check(TSSetPostStep(substeps_, call<&DamageProblem::finish_substep>));
  check(TSSetExactFinalTime(substeps_, TS_EXACTFINALTIME_MATCHSTEP));
  if (settings_.explicit_substeps > 0)
    set_explicit(substeps_);
  else
    set_implicit(substeps_);
}

void DamageProblem::set_implicit(TS ts) {
  check(TSSetType(ts, TSBEULER));
  check(TSSetTimeStep(ts, settings_.substep));
  check(TSSetIFunction(ts, nullptr, Callback<&DamageProblem::substep_residual>::call, this));
  check(TSSetIJacobian(ts, field_.matrix(), field_.matrix(), Callback<&DamageProblem::substep_tangent>::call,
                       this));
  const SNES snes = Get(TSGetSNES)(ts);
  prepare(snes);
  check(TSSetFromOptions(ts));
  suit_linear_solver(snes);
}

// lambda and the lower bound belong to the damage at the start of the sub-step.
void DamageProblem::start_substep(TS ts) {
  const Vec x = Get(TSGetSolution)(ts);
  field_.to_local(x, substep_start_);
  equation_.phi_n = &substep_start_;
  if (rate_) return weigh_nodes(Get(TSGetTimeStep)(ts));
  if (settings_.bounds != DamageBounds::vi) return;
  set_bounds(substep_start_, substep_start_);
  const SNES snes = Get(TSGetSNES)(ts);
  check(SNESVISetVariableBounds(snes, lower_, upper_));
}

void DamageProblem::finish_substep(TS ts) {
  const Vec x = Get(TSGetSolution)(ts);
  const PetscReal start = Get(TSGetPrevTime)(ts);
  const PetscReal end = Get(TSGetTime)(ts);
  if (rate_) check(VecPointwiseMin(x, x, upper_));
  field_.to_local(x, substep_end_);
  if (rate_) {
    book_substep(end - start);
    const PetscInt left = settings_.explicit_substeps - Get(TSGetStepNumber)(ts);
    if (step_.dt - end > 1e-9 * step_.dt)
      check(TSSetTimeStep(ts, substep_that_fits(step_.dt - end, left, substep_end_)));
    return;
  }
  book_rate(substep_start_, substep_end_, end - start);
}

void DamageProblem::substep_residual(TS ts, PetscReal, Vec x, Vec, Vec f) {
  // The rate is (x - start)/(theta dt) at the stage of a theta method.
  PetscReal theta = 1;
  if (has_type(ts, TSTHETA)) check(TSThetaGetTheta(ts, &theta));
  equation_.dt = theta * Get(TSGetTimeStep)(ts);
  residual(nullptr, x, f);
}

void DamageProblem::substep_tangent(TS, PetscReal, Vec x, Vec, PetscReal shift, Mat J, Mat P) {
  equation_.dt = 1 / shift;
  tangent(nullptr, x, J, P);
}

ScalarOutcome DamageProblem::solve_substeps(const DamageStep& step, std::vector<double>& phi) {
  ScalarOutcome outcome;
  PetscReal dt = 0;
  if (substep_ == 0) check(TSGetTimeStep(substeps_, &substep_));
  phi = *step.phi_n;
  boundary_.set_damage(step.t, phi);
  dt = rate_ ? substep_that_fits(step.dt, settings_.explicit_substeps, phi)
             : std::min<PetscReal>(substep_, step.dt);
  d_.scalar.to_global(phi, field_.solution());
  check(TSSetTime(substeps_, 0));
  check(TSSetStepNumber(substeps_, 0));
  check(TSSetTimeStep(substeps_, dt));
  check(TSSetMaxTime(substeps_, step.dt));
  check(TSSetMaxSteps(substeps_, PETSC_MAX_INT));
  const PetscErrorCode code = TSSolve(substeps_, field_.solution());
  const TSConvergedReason reason = Get(TSGetConvergedReason)(substeps_);
  if (reason < 0) {
    last_petsc_message();
    outcome.reason = SNES_DIVERGED_INNER;
    return outcome;
  }
  mailbox_.deliver(code);
  check(TSGetSNESIterations(substeps_, &outcome.newton));
  check(TSGetKSPIterations(substeps_, &outcome.linear));
  outcome.reason = SNES_CONVERGED_ITS;
  field_.to_local(field_.solution(), phi);
  if (settings_.bounds == DamageBounds::clip || settings_.bounds == DamageBounds::vi)
    for (std::size_t i = 0; i < phi.size(); ++i) phi[i] = std::min(1.0, std::max(phi[i], (*step.phi_n)[i]));
  book_energy(*step.phi_n, phi);
  return outcome;
}

} // namespace impact
