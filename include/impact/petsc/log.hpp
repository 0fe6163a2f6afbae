#pragma once

/// Where a run spends its time, for PETSc's -log_view: stages that part a run from its start to its end, and
/// events for the program's own work. Both are scopes, so that an exception leaves none of them open; without
/// -log_view an event costs one test.
namespace impact {

/// A stage holds what happens in it, less what happens in stages that begin inside of it.
enum class Stage { setup, steps, motion, damage, heat, output };

/// Work of its own in any stage. An event may lie inside of another one, as contact in a residual.
enum class Event {
  mesh_gmsh,      // of rank 0, for which the others wait; the reading of what gmsh wrote included
  mesh_read,      // a .msh file
  mesh_build,     // topology, groups, numbers of the nodes
  mesh_partition, // inside of mesh_build
  motion_residual,
  motion_tangent,
  motion_matrix, // its pattern, anew where contact has other pairs
  motion_points, // plastic flow and driving energies at the solution of a pass
  motion_forces, // internal and external forces apart, for balances and initial accelerations
  contact_search,
  contact_forces,  // gaps, slips and tractions of all pairs: of residuals, of augmentations, of reports
  contact_tangent, // blocks of the pairs into the matrix
  damage_residual,
  damage_tangent,
  damage_points, // driving energies before the solve and what was dissipated after it
  heat_residual,
  heat_tangent,
  heat_loads, // what the temperature of the step's end does not change
  balances,   // of energy and momentum, of a step
  history,    // a row of the history file
  field_output,
  checkpoint_write,
  checkpoint_read
};

/// The first scope of a process registers all stages and events: to be met by all ranks at the same point.
class InStage {
public:
  explicit InStage(Stage stage);
  ~InStage();
  InStage(const InStage&) = delete;
  InStage& operator=(const InStage&) = delete;
};

class Timed {
public:
  explicit Timed(Event event);
  ~Timed();
  Timed(const Timed&) = delete;
  Timed& operator=(const Timed&) = delete;

private:
  int id_;
};

} // namespace impact
