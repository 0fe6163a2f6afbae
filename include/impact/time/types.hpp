#pragma once
#include <functional>
#include <impact/petsc/error.hpp>
#include <impact/time/integrator.hpp>
#include <petscts.h>

/// Time integrators for F(t, u, v, a) = 0 as PETSc plug-ins: the TS types `newmark`, `static` (no inertia,
/// t is the load factor) and `central_difference`, which step with any Integrator (integrator.hpp), and the
/// TSAdapt type `step_control` (step_control.hpp), the default of all. The nonlinear solve of a step by
/// central differences finds u as it is and puts the acceleration there (new_acceleration). The state comes
/// through TS2SetSolution. The equations come through TSSetI2Function and TSSetI2Jacobian, or the TS's SNES
/// finds v and a of its iterates by rates_at.
///
/// Options, behind the prefix of a TS of type newmark: -ts_newmark_beta (1/4), -ts_newmark_gamma (1/2), or
/// -ts_newmark_rho (newmark_with_radius); -ts_newmark_guess extrapolated/previous: the solve starts at
/// u_tilde + dt^2/2 a_n (default) or at u_n.
///
/// The types set on their TS: no limit on failed nonlinear solves, no PETSc error for a run that gives up
/// (read TSGetConvergedReason) and TS_EXACTFINALTIME_STEPOVER, because step_control ends on the final time by
/// itself. PETSc's own limits stay: 5000 steps and t = 5 unless -ts_max_steps and -ts_max_time say otherwise.
namespace impact {

/// One try at the step from t_n to t = t_n + dt.
struct Attempt {
  PetscReal t_n = 0;
  PetscReal dt = 0;
  PetscReal t = 0;
  PetscInt number = 0; // 1 for the first try; 0 while the forces at the start are evaluated, where t = t_n
};

/// Answer of the second criterion: a refused step is tried again with dt times `factor`, 0 < factor <= 1;
/// with 1 the same step is repeated.
struct Verdict {
  bool accept = true;
  PetscReal factor = 0.5;
  bool agreed = false; ///< every rank knows that all answer the same
};

/// Empty functions are skipped. The TS's own vectors hold u_n and v_n until `on_accept`, which sees t, u, v,
/// a of the new step; step number TSGetStepNumber is still that of t_n there. Exceptions end the run through
/// time_mailbox.
struct StepHooks {
  std::function<void(TS, const Attempt&)> before_attempt = {};
  /// With inertia: u_tilde = u_n + dt v and v = v_n on entry; the step goes on from what they are afterwards.
  /// A shock that changes v changes u_tilde by dt times that.
  std::function<void(TS, const Attempt&, Vec u_tilde, Vec v)> predict = {};
  /// No step is longer than this; empty: no limit beside those of the control.
  std::function<PetscReal(TS)> longest = {};
  /// u holds the default guess of the nonlinear solve and may be changed; not with central differences.
  std::function<void(TS, const Attempt&, Vec u)> guess = {};
  /// After a converged solve, before the step is judged: v and a may be changed, u must not.
  std::function<void(TS, Vec u, Vec v, Vec a)> correct = {};
  /// Iterations that the control calls the step's effort; without it the iterations of the TS's SNES.
  std::function<PetscInt(TS)> effort = {};
  /// Part of the limits on its increments that the solved step used up, 1 at the limit: dt follows it from
  /// step to step. Empty or 0: no limits.
  std::function<PetscReal(TS)> utilisation = {};
  /// Called after a converged solve. If ranks differ the smallest factor of those that refuse counts.
  std::function<Verdict(TS, const Attempt&, Vec u, Vec v, Vec a)> accept = {};
  /// After a failed or refused try: drop the trial state.
  std::function<void(TS, const Attempt&)> on_reject = {};
  /// After the state was taken over: commit. There is no way back (TSRollBack is not offered).
  std::function<void(TS, const Attempt&)> on_accept = {};
};

/// Replaces the hooks of a TS of one of our types; to be called after the type is set
/// (set_time_options).
void set_step_hooks(TS ts, StepHooks hooks);

/// The try in progress, or the last one.
const Attempt& current_attempt(TS ts);

/// Registers the types; may be called again. Not collective, after PetscInitialize.
void register_time_types();

/// TSSetFromOptions; rethrows what the option checks threw (UserError). Collective.
void set_time_options(TS ts);

/// TSSolve on the vectors given to TS2SetSolution; rethrows what a hook threw. Collective.
void solve_in_time(TS ts);

/// Where the hooks' exceptions wait until solve_in_time has returned. Callbacks that run inside the solve
/// should store theirs here too, so that the first one is what the caller sees. Needs one of our types.
Mailbox& time_mailbox(TS ts);

/// The functions below need one of our types, too.
void set_integrator(TS ts, const Integrator& integrator);
const Integrator& integrator_of(TS ts);

/// v, alpha_m a + (1 - alpha_m) a_n and their derivatives by u at an iterate u of the try in progress; the
/// vectors are the TS's own and hold until the next call. Without inertia a_m is zero.
struct Rates {
  Vec v, a_m;
  PetscReal dv_du, da_du;
};
Rates rates_at(TS ts, Vec u);

/// The acceleration at the current time; owned by the TS. Null until it was set, which the first step with
/// inertia wants.
Vec acceleration(TS ts);
void set_acceleration(TS ts, Vec a);
/// Where the nonlinear solve of a step by central differences puts the acceleration at its end; owned by the
/// TS.
Vec new_acceleration(TS ts);
/// v at the start of the try in progress: v_n, or what the hook `predict` made of it; owned by the TS.
Vec start_velocity(TS ts);

} // namespace impact
