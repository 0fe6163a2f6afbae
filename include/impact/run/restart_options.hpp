#pragma once
#include <impact/scenario/scenario.hpp>

namespace impact {

/// The options of a run as a checkpoint holds them, one `-key value` per line: print_scenario, PETSc's
/// options that choose the time scheme, and the checksums of the mesh and of tables (as `-mesh_content`,
/// `-function_<id>_content` and `-material_<id>_hardening_content`). Collective.
std::string restart_options(MPI_Comm comm, const Scenario& scenario);

} // namespace impact
