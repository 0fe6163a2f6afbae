#pragma once

namespace impact {

/// SNES type: Newton's method for a symmetric problem with bounds (SNESVISetVariableBounds). Each iteration
/// minimises the quadratic model of the iterate within the bounds to the relative tolerance of the KSP, by
/// truncated Newton steps and projected Gauss-Seidel sweeps (C. Graeser, R. Kornhuber, J. Comput. Math. 27
/// (2009) 1): KSP and PC solve for what is free at the time, with a matrix of the whole size, so that
/// multigrid works and what it sets up serves on while the free set changes.
inline constexpr const char* vi_newton_qp = "vinewtonqp";

/// Makes the type known to PETSc; may be called again.
void register_bounded_newton();

} // namespace impact
