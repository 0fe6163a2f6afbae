#pragma once
#include <petscsnes.h>
#include <string>

/// What the nonlinear solvers of all fields have in common: only a residual within its tolerance is a
/// solution.
namespace impact {

/// Raises the absolute tolerance to the norm of 1e-15 of `sizes`: the terms summed in each row. Collective.
void allow_rounding(SNES snes, Vec sizes);

/// Why the solve ended: SNES_DIVERGED_LINE_SEARCH in place of a convergence that says nothing about the
/// residual, SNES_CONVERGED_FNORM_ABS where a line search found no smaller one than rounding allows.
SNESConvergedReason reason_by_residual(SNES snes);

/// The linear solver that `snes` has: "preonly + lu by mumps".
std::string linear_solver_text(SNES snes);

} // namespace impact
