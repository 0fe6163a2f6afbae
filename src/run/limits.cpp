#include <algorithm>
#include <impact/run/limits.hpp>
#include <impact/time/step_control.hpp>

namespace impact {

// Newton's method on ever shorter steps of a static run: hardly for want of iterations.
void tell_of_limits(RunStage& stage, const std::string& cause, Vec u) {
  const MPI_Comm comm = stage.d.mesh.comm();
  const TimeScenario& time = stage.scenario.time;
  double longest = time.dt;
  for (const double dt : time.table_dts) longest = std::max(longest, dt);
  if (stage.inertia || !cause.starts_with("motion: ") || step_control_state(stage.ts).dt > 1e-3 * longest)
    return;
  const auto tell = [&](const char* text) { check(PetscFPrintf(comm, PETSC_STDERR, "impact: %s\n", text)); };
  if (cause.find("LINEAR_SOLVE") != std::string::npos)
    return tell(
        "no linear solve found a solution: another -motion_pc_type (lu) or a larger -motion_ksp_max_it");
  if (stage.coupling.motion_solver().arc_length() != nullptr)
    return tell("no shorter step found where the path leads on: loads that bodies ask for must be ones that "
                "conditions have at some t, of either sign");
  const bool has_path = stage.setup->contacts.empty();
  check(PetscFPrintf(
      comm, PETSC_STDERR,
      "impact: no shorter step found an equilibrium; where a load reaches its limit, or a state snaps into "
      "another one, there is none: prescribe displacements, %sor take inertia (-ts_type newmark)\n",
      has_path ? "follow the bodies by -ts_path_length or a crack by -ts_path_dissipation, " : ""));
  for (const ContactInterface& contact : stage.setup->contacts) {
    const ContactSettings& s = contact.settings();
    if (contact.reach(u).gap > 1e-6 * stage.d.mesh.smallest_edge()) continue; // apart
    if (s.enforce == Enforcement::semismooth) // what presses changes for long along slender bodies
      check(PetscFPrintf(comm, PETSC_STDERR,
                         "impact: contact %s may not come to rest: try -contact_%s_enforce auglag\n",
                         s.id.c_str(), s.id.c_str()));
    if (s.method == ContactMethod::gauss_points && s.friction > 0) // more points than nodes rub
      check(PetscFPrintf(comm, PETSC_STDERR,
                         "impact: contact %s rubs at Gauss points: try -contact_%s_method mortar, whose "
                         "multipliers stand at nodes\n",
                         s.id.c_str(), s.id.c_str()));
  }
}

} // namespace impact
