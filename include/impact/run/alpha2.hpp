#pragma once
#include <impact/petsc/error.hpp>
#include <impact/problem/coupling.hpp>
#include <impact/run/setup.hpp>

namespace impact {

/// The same problem under PETSc's own generalised-alpha integrator (-ts_type alpha2, -ts_alpha_*): an
/// independent check of `newmark` for elastic bodies. PETSc 3.18 starts it with half steps and keeps its
/// acceleration to itself, so there are no checkpoints, and work and balance are `nan` in the history.
/// Collective. Throws UserError(usage) with plasticity, damage, viscosity or contact, which its start-up
/// would spoil.
ExitCode simulate_alpha2(MPI_Comm comm, const Scenario& scenario, Setup& setup, const SolverDefaults& solver);

} // namespace impact
