#pragma once
#include <impact/petsc/error.hpp>
#include <impact/run/scenario.hpp>

/// One run from a validated scenario to its last output.
namespace impact {

/// Builds mesh, problems and integrator in dependency order, steps to the end and reports. Collective.
/// Returns ok, or solver when the integrator gave up (after what could be saved was saved).
/// Throws UserError for what the user can mend.
ExitCode simulate(MPI_Comm comm, const Scenario& scenario);

} // namespace impact
