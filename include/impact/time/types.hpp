#pragma once
#include <impact/petsc/error.hpp>
#include <impact/time/integrator.hpp>
#include <petscts.h>

/// Time integrators for F(t, u, v, a) = 0 as PETSc plug-ins: the TS types `newmark` and `static` (no inertia,
/// t is the load factor), which step with any Integrator (integrator.hpp), and the TSAdapt type
/// `step_control` (step_control.hpp), the default of both. The state comes through TS2SetSolution. The
/// equations come through TSSetI2Function and TSSetI2Jacobian, or the TS's SNES finds v and a of its iterates
/// by rates_at.
///
/// Options, behind the prefix of a TS of type newmark: -ts_newmark_beta (1/4), -ts_newmark_gamma (1/2), or
/// -ts_newmark_rho (newmark_with_radius); -ts_newmark_guess extrapolated/previous: the solve starts at
/// u_tilde + dt^2/2 a_n (default) or at u_n.
///
/// The types set on their TS: no limit on failed nonlinear solves, no PETSc error for a run that gives up
/// (read TSGetConvergedReason) and TS_EXACTFINALTIME_STEPOVER, because step_control ends on the final time by
/// itself. PETSc's own limits stay: 5000 steps and t = 5 unless -ts_max_steps and -ts_max_time say otherwise.
namespace impact {

/// Registers the types; may be called again. Not collective, after PetscInitialize.
void register_time_types();

/// TSSetFromOptions; rethrows what the option checks threw (UserError). Collective.
void set_time_options(TS ts);

/// TSSolve on the vectors given to TS2SetSolution; rethrows what a hook threw. Collective.
void solve_in_time(TS ts);

/// Where the hooks' exceptions wait until solve_in_time has returned. Callbacks that run inside the solve
/// should store theirs here too, so that the first one is what the caller sees. Needs type newmark or static.
Mailbox& time_mailbox(TS ts);

/// The functions below need type newmark or static, too.
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
/// v at the start of the try in progress: v_n, or what the hook `predict` made of it; owned by the TS.
Vec start_velocity(TS ts);

} // namespace impact
