#pragma once
#include <functional>
#include <petscts.h>

/// What a program does around the attempts of a step. All of it is collective: every rank must take the same
/// way.
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
};

/// Empty functions are skipped. The TS's own vectors hold u_n and v_n until `on_accept`, which sees t, u, v,
/// a of the new step; step number TSGetStepNumber is still that of t_n there. Exceptions end the run through
/// time_mailbox.
struct StepHooks {
  std::function<void(TS, const Attempt&)> before_attempt = {};
  /// With inertia: u_tilde = u_n + dt v and v = v_n on entry; the step goes on from what they are afterwards.
  /// A shock that changes v changes u_tilde by dt times that.
  std::function<void(TS, const Attempt&, Vec u_tilde, Vec v)> predict = {};
  /// u holds the default guess of the nonlinear solve and may be changed.
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

/// Replaces the hooks of a TS of type newmark or static; to be called after the type is set
/// (set_time_options).
void set_step_hooks(TS ts, StepHooks hooks);

/// The try in progress, or the last one.
const Attempt& current_attempt(TS ts);

} // namespace impact
