#pragma once
#include <impact/scenario/scenario.hpp>
#include <petscsnes.h>
#include <set>

/// Options that PETSc reads: tried before the mesh is read, looked for again when the solvers have worked.
namespace impact {

/// Sets small solvers up from the options: throws UserError(usage) for a value that PETSc refuses.
/// Collective.
void try_petsc_options(MPI_Comm comm, const Scenario& scenario);

/// Whether Newmark's steps are to damp; the TS has not read its options yet. Not collective.
bool asks_for_damped_steps();

/// Tells which options the solvers of the fields read and have no use for, as a direct solver has for
/// `-motion_ksp_rtol`; throws UserError(usage) with -options_strict. Collective.
void tell_idle_options(MPI_Comm comm, const Scenario& scenario, const std::vector<SNES>& solvers);

/// Options that nothing reads. Their names are right (check_option_names), so that only a solve tells which
/// of them it had a use for: `-motion_pc_gamg_threshold` has none beside `-motion_pc_type lu`, a level's
/// option none without that level.
class UnreadOptions {
public:
  /// Notes what is unread so far; options of fields that the run does not solve are told now, for fragments
  /// of solver options go with every run. Collective.
  UnreadOptions(MPI_Comm comm, const Scenario& scenario);

  /// To be called after each step with the fields ("motion", ...) whose linear solver has worked in it.
  /// Throws UserError(usage) for what those did not read and the command line says, but for an option of a
  /// field's own solver: that, and what an options file says, is told, and refused with -options_strict.
  /// Collective.
  void judge(const std::vector<std::string>& solved);

private:
  MPI_Comm comm_;
  bool strict_;
  std::set<std::string> pending_; ///< option names
  std::set<std::string> solved_;
};

} // namespace impact
