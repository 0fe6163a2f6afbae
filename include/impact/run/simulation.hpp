#pragma once
#include <impact/mesh/state_table.hpp>
#include <impact/petsc/error.hpp>
#include <impact/scenario/scenario.hpp>
#include <impact/time/types.hpp>

/// One run from a validated scenario to its last output.
namespace impact {

/// Sees, and may disturb, the state around every try at a step: how tests inject faults. Empty functions are
/// skipped.
struct StepProbe {
  std::function<void(const Attempt&, long step, StateTable&)> before = {}; ///< rows are rolled back
  std::function<void(const Attempt&, long step, StateTable&)> after = {};  ///< taken over or refused
};

/// Builds mesh, problems and integrator in dependency order, steps to the end and reports. Collective.
/// Returns ok, or solver when the integrator gave up (after what could be saved was saved).
/// Throws UserError for what the user can mend.
ExitCode simulate(MPI_Comm comm, const Scenario& scenario, const StepProbe& probe = {});

} // namespace impact
