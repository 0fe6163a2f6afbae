#pragma once
#include <impact/petsc/error.hpp>
#include <petscts.h>

/// Time integrators for F(t, u, v, a) = 0 as PETSc plug-ins: the TS types `newmark` (newmark.hpp) and
/// `static` (no inertia, v = (u - u_n)/dt, t is the load factor) and the TSAdapt type `step_control`
/// (step_control.hpp), the default of both. The residual comes through TSSetI2Function and TSSetI2Jacobian,
/// the state through TS2SetSolution.
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

} // namespace impact
