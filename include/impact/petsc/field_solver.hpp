#pragma once
#include <impact/petsc/error.hpp>
#include <petscsnes.h>
#include <string>

/// What the nonlinear solvers of all fields have in common: only a residual within its tolerance is a
/// solution.
namespace impact {

/// How the solve for a scalar field ended.
struct ScalarOutcome {
  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  PetscInt newton = 0, linear = 0;
  std::string cause = {}; ///< of a failure, where there is more to say than its reason
};

/// Solves for x; rethrows what a callback left in `mailbox`. Collective.
ScalarOutcome solve_field(SNES snes, Vec x, Mailbox& mailbox);

/// Raises the absolute tolerance to the norm of 1e-15 of `sizes`: the terms summed in each row. Collective.
void allow_rounding(SNES snes, Vec sizes);

/// Why the solve ended: SNES_DIVERGED_LINE_SEARCH in place of a convergence that says nothing about the
/// residual, SNES_CONVERGED_FNORM_ABS where a line search found no smaller one than rounding allows.
SNESConvergedReason reason_by_residual(SNES snes);

/// cg + icc, in blocks of the ranks, for the linear solver of a scalar field whose options bear `prefix`:
/// before they are read.
void set_scalar_solver_defaults(KSP ksp, const char* prefix);

/// The linear solver that `snes` has: "preonly + lu by mumps".
std::string linear_solver_text(SNES snes);

} // namespace impact
