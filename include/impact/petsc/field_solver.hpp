#pragma once
#include <initializer_list>
#include <petscsnes.h>
#include <string>

/// What the nonlinear solvers of all fields have in common: only a residual within its tolerance is a
/// solution.
namespace impact {

/// Refuses options that would leave a solver without an answer: throws UserError(usage) for a
/// -<prefix>snes_type that is none of `types`, and for a positive -<prefix>snes_stol, since a short step is
/// no sign of a solution: a failed line search and a failed linear solve make one too.
void check_solver_options(const char* prefix, std::initializer_list<SNESType> types);

/// Raises the absolute tolerance to the norm of 1e-15 of `sizes`: the terms summed in each row. Collective.
void allow_rounding(SNES snes, Vec sizes);

/// Why the solve ended: SNES_DIVERGED_LINE_SEARCH in place of a convergence that says nothing about the
/// residual, SNES_CONVERGED_FNORM_ABS where a line search found no smaller one than rounding allows.
SNESConvergedReason reason_by_residual(SNES snes);

/// The linear solver that `snes` has: "preonly + lu by mumps".
std::string linear_solver_text(SNES snes);

} // namespace impact
