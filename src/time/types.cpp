#include "control.hpp"
#include "integrator.hpp"
#include <algorithm>
#include <impact/time/types.hpp>
#include <memory>
#include <stdexcept>

namespace impact {

namespace detail {

namespace {

Integrator& self(TS ts) { return *static_cast<Integrator*>(ts->data); }

bool has_our_type(TS ts) {
  PetscBool ours = PETSC_FALSE;
  check(PetscObjectTypeCompareAny(reinterpret_cast<PetscObject>(ts), &ours, newmark_type, static_type, ""));
  return ours;
}

} // namespace

Integrator& integrator(TS ts) {
  if (!has_our_type(ts)) throw std::logic_error("the TS is of neither type newmark nor static");
  return self(ts);
}

namespace {

// Sets ts->time_step and the attempt. A foreign TSAdapt has set ts->time_step itself.
void begin_attempt(TS ts, Integrator& integrator, PetscInt number) {
  StepPlan plan{ts->time_step, ts->ptime + ts->time_step};
  if (StepControl* const control = find_control(ts)) plan = plan_step(ts, *control);
  ts->time_step = plan.dt;
  integrator.attempt = {.t_n = ts->ptime, .dt = plan.dt, .t = plan.t, .number = number};
}

// True when the nonlinear solve converged; otherwise TSAdaptCheckStage has cut ts->time_step.
bool solve_stage(TS ts, Integrator& integrator) {
  Vec u = integrator.trial.u;
  predict(ts, integrator);
  if (integrator.hooks.guess) integrator.hooks.guess(ts, integrator.attempt, u);
  check(TSPreStage(ts, integrator.attempt.t));
  check(SNESSolve(ts->snes, nullptr, u));
  PetscInt nonlinear = 0, linear = 0;
  check(SNESGetIterationNumber(ts->snes, &nonlinear));
  check(SNESGetLinearSolveIterations(ts->snes, &linear));
  ts->snes_its += nonlinear;
  ts->ksp_its += linear;
  check(TSPostStage(ts, integrator.attempt.t, 0, &u));
  PetscBool converged = PETSC_FALSE;
  check(TSAdaptCheckStage(ts->adapt, ts, integrator.attempt.t, u, &converged));
  return converged;
}

// The second criterion. What ranks answer differently is settled by the strictest one.
bool judge(TS ts, Integrator& integrator) {
  if (!integrator.hooks.accept) return true;
  const Trial& trial = integrator.trial;
  const Verdict verdict = integrator.hooks.accept(ts, integrator.attempt, trial.u, trial.v, trial.a);
  if (!verdict.accept && !(verdict.factor > 0 && verdict.factor <= 1))
    throw std::logic_error("a refused step needs a factor between 0 and 1");
  constexpr PetscReal accepted = 2;
  PetscReal factor = verdict.accept ? accepted : verdict.factor;
  MPI_Allreduce(MPI_IN_PLACE, &factor, 1, MPIU_REAL, MPIU_MIN,
                PetscObjectComm(reinterpret_cast<PetscObject>(ts)));
  if (factor == accepted) return true;
  ts->time_step *= factor;
  return false;
}

// Solves and judges one try; true when it is to be taken over, with the size of the next step.
bool attempt_step(TS ts, Integrator& integrator, PetscReal& next_dt) {
  if (integrator.hooks.before_attempt) integrator.hooks.before_attempt(ts, integrator.attempt);
  if (!solve_stage(ts, integrator)) return false;
  const Trial& trial = integrator.trial;
  rates(ts, integrator, trial.u); // SNES does not promise that its last evaluation was at the solution
  if (integrator.scheme.hooks.correct) integrator.scheme.hooks.correct(ts, trial.u, trial.v, trial.a);
  if (!judge(ts, integrator)) return false;
  if (StepControl* const control = find_control(ts)) {
    check(SNESGetIterationNumber(ts->snes, &control->effort));
    if (integrator.hooks.effort) control->effort = integrator.hooks.effort(ts);
    if (integrator.hooks.utilisation) control->utilisation = integrator.hooks.utilisation(ts);
  }
  PetscBool accept = PETSC_TRUE;
  check(TSAdaptChoose(ts->adapt, ts, integrator.attempt.dt, nullptr, &next_dt, &accept));
  if (!accept) ts->time_step = next_dt;
  return accept;
}

void take_over(TS ts, Integrator& integrator, PetscReal next_dt) {
  const Trial& trial = integrator.trial;
  check(VecCopy(trial.u, ts->vec_sol));
  check(VecCopy(trial.v, ts->vec_dot));
  if (integrator.scheme.inertia) check(VecCopy(trial.a, integrator.a));
  ts->ptime = integrator.attempt.t;
  ts->time_step = next_dt;
  if (integrator.hooks.on_accept) integrator.hooks.on_accept(ts, integrator.attempt);
}

void refuse(TS ts, Integrator& integrator) {
  if (integrator.hooks.on_reject) integrator.hooks.on_reject(ts, integrator.attempt);
  PetscReal least = ts->adapt->dt_min;
  if (StepControl* const control = find_control(ts)) {
    least = std::max(least, smallest_step(*control, integrator.attempt.t_n));
    note_rejection(ts, *control);
  }
  ++ts->reject;
  // Below the last digits of t a smaller step only repeats the failure.
  const bool vanished = integrator.attempt.t_n + 16 * ts->time_step == integrator.attempt.t_n;
  const bool too_often = ts->max_reject >= 0 && integrator.attempt.number > ts->max_reject;
  if (!ts->reason && (too_often || vanished || ts->time_step < least)) ts->reason = TS_DIVERGED_STEP_REJECTED;
}

PetscErrorCode step(TS ts) {
  return self(ts).mailbox.guarded([&] {
    Integrator& integrator = self(ts);
    start(ts, integrator);
    for (PetscInt number = 1; !ts->reason; ++number) {
      begin_attempt(ts, integrator, number);
      PetscReal next_dt = ts->time_step;
      if (attempt_step(ts, integrator, next_dt)) {
        take_over(ts, integrator, next_dt);
        return;
      }
      refuse(ts, integrator);
    }
  });
}

PetscErrorCode set_up(TS ts) {
  return self(ts).mailbox.guarded([&] {
    if (ts->vec_dot == nullptr) throw std::logic_error("newmark, static: give u and v by TS2SetSolution");
    Trial& trial = self(ts).trial;
    for (Handle<Vec>* vec : {&trial.u_tilde, &trial.v_start, &trial.u, &trial.v, &trial.a, &trial.a_m}) {
      check(VecDuplicate(ts->vec_sol, vec->out()));
      check(VecZeroEntries(*vec));
    }
    check(TSGetAdapt(ts, &ts->adapt));
    check(TSAdaptCandidatesClear(ts->adapt));
    check(TSGetSNES(ts, &ts->snes));
  });
}

PetscErrorCode residual(SNES, Vec u, Vec r, TS ts) {
  return self(ts).mailbox.guarded([&] {
    Integrator& integrator = self(ts);
    const Trial& trial = integrator.trial;
    rates(ts, integrator, u);
    check(TSComputeI2Function(ts, integrator.attempt.t, u, trial.v, trial.a_m, r));
  });
}

PetscErrorCode jacobian(SNES, Vec u, Mat J, Mat P, TS ts) {
  return self(ts).mailbox.guarded([&] {
    Integrator& integrator = self(ts);
    const Trial& trial = integrator.trial;
    const Shifts shift = shifts(integrator);
    rates(ts, integrator, u);
    check(TSComputeI2Jacobian(ts, integrator.attempt.t, u, trial.v, trial.a_m, shift.v, shift.a, J, P));
  });
}

PetscErrorCode set_from_options(TS ts, OptionItems PetscOptionsObject) {
  return self(ts).mailbox.guarded([&] {
    if (self(ts).scheme.inertia) read_newmark_options(ts, self(ts), PetscOptionsObject);
  });
}

PetscErrorCode view(TS ts, PetscViewer viewer) {
  const auto [beta, gamma, alpha_m] = self(ts).scheme.parameters;
  if (!self(ts).scheme.inertia) return PetscViewerASCIIPrintf(viewer, "  no inertia\n");
  return PetscViewerASCIIPrintf(viewer, "  beta %g, gamma %g, alpha_m %g\n", static_cast<double>(beta),
                                static_cast<double>(gamma), static_cast<double>(alpha_m));
}

// The accelerations a_n and the parameters survive TSReset: they belong to the state, not to the work space.
PetscErrorCode reset(TS ts) {
  self(ts).trial = Trial{};
  return {};
}

PetscErrorCode destroy(TS ts) {
  const std::unique_ptr<Integrator> owned(&self(ts));
  ts->data = nullptr;
  return {};
}

PetscErrorCode create(TS ts, bool inertia) {
  auto integrator = std::make_unique<Integrator>();
  integrator->scheme.inertia = inertia;
  ts->data = integrator.release();
  ts->usessnes = PETSC_TRUE;
  ts->default_adapt_type = step_control_type;
  ts->ops->setup = set_up;
  ts->ops->step = step;
  ts->ops->snesfunction = residual;
  ts->ops->snesjacobian = jacobian;
  ts->ops->setfromoptions = set_from_options;
  ts->ops->view = view;
  ts->ops->reset = reset;
  ts->ops->destroy = destroy;
  return self(ts).mailbox.guarded([&] {
    check(TSSetMaxSNESFailures(ts, unlimited));
    check(TSSetErrorIfStepFails(ts, PETSC_FALSE));
    check(TSSetExactFinalTime(ts, TS_EXACTFINALTIME_STEPOVER));
  });
}

PetscErrorCode create_newmark(TS ts) { return create(ts, true); }
PetscErrorCode create_static(TS ts) { return create(ts, false); }

// What the hooks or the options threw first, else what PETSc said.
void deliver(TS ts, PetscErrorCode code) {
  if (code == 0) return;
  TSAdapt adapt = nullptr;
  check(TSGetAdapt(ts, &adapt));
  if (StepControl* const control = find_control(ts)) control->mailbox.deliver({});
  if (has_our_type(ts)) self(ts).mailbox.deliver(code);
  check(code);
}

} // namespace
} // namespace detail

void register_time_types() {
  check(TSRegister(detail::newmark_type, detail::create_newmark));
  check(TSRegister(detail::static_type, detail::create_static));
  detail::register_step_control();
}

void set_time_options(TS ts) { detail::deliver(ts, TSSetFromOptions(ts)); }

void solve_in_time(TS ts) { detail::deliver(ts, TSSolve(ts, nullptr)); }

Mailbox& time_mailbox(TS ts) { return detail::integrator(ts).mailbox; }

void set_step_hooks(TS ts, StepHooks hooks) { detail::integrator(ts).hooks = std::move(hooks); }

const Attempt& current_attempt(TS ts) { return detail::integrator(ts).attempt; }

} // namespace impact
