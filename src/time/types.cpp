#include "step_data.hpp"
#include <algorithm>
#include <impact/petsc/field_solver.hpp>
#include <impact/petsc/ranks.hpp>
#include <memory>
#include <stdexcept>

namespace impact {

namespace detail {

namespace {

constexpr const char *newmark_type = "newmark", *static_type = "static",
                     *explicit_type = "central_difference";

StepData& self(TS ts) { return *static_cast<StepData*>(ts->data); }

bool has_our_type(TS ts) { return has_type(ts, newmark_type, static_type, explicit_type); }

StepData& step_data(TS ts) {
  if (!has_our_type(ts))
    throw std::logic_error("the TS is of none of the types newmark, static, central_difference");
  return self(ts);
}

// Sets u_tilde and the first guess of trial.u.
void predict(TS ts, StepData& self) {
  const Attempt& step = self.attempt;
  Trial& trial = self.trial;
  if (!self.integrator.inertia) return check(VecCopy(ts->vec_sol, trial.u));
  check(VecWAXPY(trial.u_tilde, step.dt, ts->vec_dot, ts->vec_sol));
  check(VecCopy(ts->vec_dot, trial.v_start));
  if (self.hooks.predict) self.hooks.predict(ts, step, trial.u_tilde, trial.v_start);
  if (self.extrapolate || self.integrator.is_explicit()) // beta = 0: this is u
    check(VecWAXPY(trial.u, step.dt * step.dt / 2, self.a, trial.u_tilde));
  else
    check(VecCopy(ts->vec_sol, trial.u));
}

// v, a and a_m of the trial for displacement u (97-98).
void find_rates(TS ts, StepData& self, Vec u) {
  Trial& trial = self.trial;
  if (!self.integrator.inertia) {
    check(VecWAXPY(trial.v, -1, ts->vec_sol, u));
    return check(VecScale(trial.v, 1 / self.attempt.dt));
  }
  if (self.integrator.is_explicit()) { // trial.a is what the solve found
    const PetscReal dt = self.attempt.dt, gamma = self.integrator.gamma;
    check(VecCopy(trial.v_start, trial.v));
    check(VecAXPBYPCZ(trial.v, (1 - gamma) * dt, gamma * dt, 1, self.a, trial.a)); // (97)
    return;
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

// Predictor, guess and nonlinear solve into trial.u. True when it converged; otherwise TSAdaptCheckStage has
// cut ts->time_step.
bool solve_stage(TS ts, StepData& self) {
  Vec u = self.trial.u;
  predict(ts, self);
  if (self.hooks.guess && !self.integrator.is_explicit()) self.hooks.guess(ts, self.attempt, u);
  check(TSPreStage(ts, self.attempt.t));
  check(SNESSolve(ts->snes, nullptr, u));
  const PetscInt nonlinear = Get(SNESGetIterationNumber)(ts->snes);
  const PetscInt linear = Get(SNESGetLinearSolveIterations)(ts->snes);
  ts->snes_its += nonlinear;
  ts->ksp_its += linear;
  check(TSPostStage(ts, self.attempt.t, 0, &u));
  PetscBool converged = PETSC_FALSE;
  check(TSAdaptCheckStage(ts->adapt, ts, self.attempt.t, u, &converged));
  return converged;
}

// Sets ts->time_step and the attempt. A foreign TSAdapt has set ts->time_step itself.
void begin_attempt(TS ts, StepData& data, PetscInt number) {
  StepPlan plan{ts->time_step, ts->ptime + ts->time_step};
  if (StepControl* const control = find_control(ts)) {
    if (data.hooks.longest) control->longest = data.hooks.longest(ts);
    plan = plan_step(ts, *control);
  }
  ts->time_step = plan.dt;
  data.attempt = {.t_n = ts->ptime, .dt = plan.dt, .t = plan.t, .number = number};
}

// The second criterion. What ranks answer differently is settled by the strictest one.
bool judge(TS ts, StepData& data) {
  if (!data.hooks.accept) return true;
  const Trial& trial = data.trial;
  const Verdict verdict = data.hooks.accept(ts, data.attempt, trial.u, trial.v, trial.a);
  if (!verdict.accept && !(verdict.factor > 0 && verdict.factor <= 1))
    throw std::logic_error("a refused step needs a factor between 0 and 1");
  constexpr PetscReal accepted = 2;
  PetscReal factor = verdict.accept ? accepted : verdict.factor;
  if (!verdict.agreed) factor = min_over_ranks(PetscObjectComm(reinterpret_cast<PetscObject>(ts)), factor);
  if (factor == accepted) return true;
  ts->time_step *= factor;
  return false;
}

// Solves and judges one try; true when it is to be taken over, with the size of the next step.
bool attempt_step(TS ts, StepData& data, PetscReal& next_dt) {
  if (data.hooks.before_attempt) data.hooks.before_attempt(ts, data.attempt);
  if (!solve_stage(ts, data)) return false;
  const Trial& trial = data.trial;
  find_rates(ts, data, trial.u); // SNES does not promise that its last evaluation was at the solution
  if (data.hooks.correct) data.hooks.correct(ts, trial.u, trial.v, trial.a);
  if (!judge(ts, data)) return false;
  if (StepControl* const control = find_control(ts)) {
    check(SNESGetIterationNumber(ts->snes, &control->effort));
    if (data.hooks.effort) control->effort = data.hooks.effort(ts);
    if (data.hooks.utilisation) control->utilisation = data.hooks.utilisation(ts);
  }
  PetscBool accept = PETSC_TRUE;
  check(TSAdaptChoose(ts->adapt, ts, data.attempt.dt, nullptr, &next_dt, &accept));
  if (!accept) ts->time_step = next_dt;
  return accept;
}

void take_over(TS ts, StepData& data, PetscReal next_dt) {
  const Trial& trial = data.trial;
  check(VecCopy(trial.u, ts->vec_sol));
  check(VecCopy(trial.v, ts->vec_dot));
  if (data.integrator.inertia) check(VecCopy(trial.a, data.a));
  ts->ptime = data.attempt.t;
  ts->time_step = next_dt;
  if (data.hooks.on_accept) data.hooks.on_accept(ts, data.attempt);
}

void refuse(TS ts, StepData& data) {
  if (data.hooks.on_reject) data.hooks.on_reject(ts, data.attempt);
  PetscReal least = ts->adapt->dt_min;
  if (StepControl* const control = find_control(ts)) {
    least = std::max(least, smallest_step(*control, data.attempt.t_n));
    note_rejection(ts, *control);
  }
  ++ts->reject;
  // Below the last digits of t a smaller step only repeats the failure.
  const bool vanished = data.attempt.t_n + 16 * ts->time_step == data.attempt.t_n;
  const bool too_often = ts->max_reject >= 0 && data.attempt.number > ts->max_reject;
  if (!ts->reason && (too_often || vanished || ts->time_step < least)) ts->reason = TS_DIVERGED_STEP_REJECTED;
}

PetscErrorCode step(TS ts) {
  return self(ts).mailbox.guarded([&] {
    StepData& data = self(ts);
    if (data.integrator.inertia && !data.a)
      throw std::logic_error("give the acceleration of the start by set_acceleration");
    for (PetscInt number = 1; !ts->reason; ++number) {
      begin_attempt(ts, data, number);
      PetscReal next_dt = ts->time_step;
      if (attempt_step(ts, data, next_dt)) {
        take_over(ts, data, next_dt);
        return;
      }
      refuse(ts, data);
    }
  });
}

PetscErrorCode set_up(TS ts) {
  return self(ts).mailbox.guarded([&] {
    if (ts->vec_dot == nullptr) throw std::logic_error("give u and v by TS2SetSolution");
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

// A TS whose own SNES solves for u, with the residual given by TSSetI2Function.
PetscErrorCode residual(SNES, Vec u, Vec r, TS ts) {
  return self(ts).mailbox.guarded([&] {
    const Rates rates = rates_at(ts, u);
    check(TSComputeI2Function(ts, self(ts).attempt.t, u, rates.v, rates.a_m, r));
  });
}

PetscErrorCode jacobian(SNES, Vec u, Mat J, Mat P, TS ts) {
  return self(ts).mailbox.guarded([&] {
    const Rates rates = rates_at(ts, u);
    check(TSComputeI2Jacobian(ts, self(ts).attempt.t, u, rates.v, rates.a_m, rates.dv_du, rates.da_du, J, P));
  });
}

void check_range(const char* option, PetscReal value, bool allowed, const char* range, const char* remedy) {
  if (!allowed)
    throw UserError(ExitCode::usage, std::string(option) + ": " + std::to_string(value) +
                                         "; allowed: " + range + "; " + remedy);
}

// -ts_newmark_beta, _gamma, _rho, _guess.
void read_newmark_options(StepData& self, OptionItems PetscOptionsObject) {
  Integrator& p = self.integrator;
  PetscReal rho = 1;
  PetscBool beta = PETSC_FALSE, gamma = PETSC_FALSE, radius = PETSC_FALSE;
  check(PetscOptionsReal("-ts_newmark_beta", "Newmark's beta", nullptr, p.beta, &p.beta, &beta));
  check(PetscOptionsReal("-ts_newmark_gamma", "Newmark's gamma", nullptr, p.gamma, &p.gamma, &gamma));
  check(PetscOptionsReal("-ts_newmark_rho", "Spectral radius at infinite frequency", nullptr, rho, &rho,
                         &radius));
  const char* const guesses[] = {"previous", "extrapolated"};
  PetscInt guess = self.extrapolate ? 1 : 0;
  check(PetscOptionsEList("-ts_newmark_guess", "Start of the nonlinear solve", nullptr, guesses, 2,
                          guesses[guess], &guess, nullptr));
  self.extrapolate = guess == 1;
  if (radius) {
    check_range("-ts_newmark_rho", rho, rho >= 0 && rho <= 1, "0 <= rho <= 1", "1 damps nothing, 0 most");
    check_range("-ts_newmark_rho", rho, !beta && !gamma,
                "not together with -ts_newmark_beta or -ts_newmark_gamma", "give one or the other");
    p = newmark_with_radius(rho);
  }
  check_range("-ts_newmark_beta", p.beta, p.beta > 0 && p.beta <= 1, "0 < beta <= 1", "leave it out for 1/4");
  check_range("-ts_newmark_gamma", p.gamma, p.gamma >= 0.5 && p.gamma <= 2,
              "1/2 <= gamma <= 2, stable from 1/2 on", "leave it out for 1/2");
}

PetscErrorCode set_from_options(TS ts, OptionItems PetscOptionsObject) {
  return self(ts).mailbox.guarded([&] {
    if (self(ts).reads_weights) read_newmark_options(self(ts), PetscOptionsObject);
  });
}

PetscErrorCode view(TS ts, PetscViewer viewer) {
  const Integrator& scheme = self(ts).integrator;
  if (!scheme.inertia) return PetscViewerASCIIPrintf(viewer, "  no inertia\n");
  return PetscViewerASCIIPrintf(viewer, "  beta %g, gamma %g, alpha_m %g\n", static_cast<double>(scheme.beta),
                                static_cast<double>(scheme.gamma), static_cast<double>(scheme.alpha_m));
}

// The accelerations a_n and the parameters survive TSReset: they belong to the state, not to the work space.
PetscErrorCode reset(TS ts) {
  self(ts).trial = Trial{};
  return {};
}

PetscErrorCode destroy(TS ts) {
  const std::unique_ptr<StepData> owned(&self(ts));
  ts->data = nullptr;
  return {};
}

PetscErrorCode create(TS ts, const Integrator& integrator, bool reads_weights) {
  auto data = std::make_unique<StepData>();
  data->integrator = integrator;
  data->reads_weights = reads_weights;
  ts->data = data.release();
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

PetscErrorCode create_newmark(TS ts) { return create(ts, {}, true); }
PetscErrorCode create_static(TS ts) { return create(ts, {.inertia = false}, false); }
PetscErrorCode create_explicit(TS ts) { return create(ts, central_differences(), false); }

// What the hooks or the options threw first, else what PETSc said.
void deliver(TS ts, PetscErrorCode code) {
  if (code == 0) return;
  if (StepControl* const control = find_control(ts)) control->mailbox.deliver({});
  if (has_our_type(ts)) self(ts).mailbox.deliver(code);
  check(code);
}

} // namespace
} // namespace detail

void register_time_types() {
  check(TSRegister(detail::newmark_type, detail::create_newmark));
  check(TSRegister(detail::static_type, detail::create_static));
  check(TSRegister(detail::explicit_type, detail::create_explicit));
  detail::register_step_control();
}

void set_time_options(TS ts) { detail::deliver(ts, TSSetFromOptions(ts)); }

void solve_in_time(TS ts) { detail::deliver(ts, TSSolve(ts, nullptr)); }

Mailbox& time_mailbox(TS ts) { return detail::step_data(ts).mailbox; }

void set_step_hooks(TS ts, StepHooks hooks) { detail::step_data(ts).hooks = std::move(hooks); }

const Attempt& current_attempt(TS ts) { return detail::step_data(ts).attempt; }

void set_integrator(TS ts, const Integrator& integrator) { detail::step_data(ts).integrator = integrator; }

const Integrator& integrator_of(TS ts) { return detail::step_data(ts).integrator; }

Rates rates_at(TS ts, Vec u) {
  detail::StepData& data = detail::step_data(ts);
  detail::find_rates(ts, data, u);
  const detail::Trial& trial = data.trial;
  const PetscReal dt = data.attempt.dt;
  if (!data.integrator.inertia) return {trial.v, trial.a_m, 1 / dt, 0};
  const Integrator::Coefficients chi = data.integrator.coefficients(dt);
  return {trial.v, trial.a_m, chi.chi4, data.integrator.alpha_m * chi.chi1};
}

Vec acceleration(TS ts) {
  const detail::StepData& data = detail::step_data(ts);
  return data.a ? data.a.get() : nullptr;
}

void set_acceleration(TS ts, Vec a) {
  detail::StepData& data = detail::step_data(ts);
  if (!data.a) check(VecDuplicate(a, data.a.out()));
  check(VecCopy(a, data.a));
}

Vec new_acceleration(TS ts) { return detail::step_data(ts).trial.a; }

Vec start_velocity(TS ts) { return detail::step_data(ts).trial.v_start; }

} // namespace impact
