#pragma once
#include <impact/balance/ledger.hpp>
#include <impact/io/checkpoint.hpp>
#include <impact/problem/erosion.hpp>
#include <impact/run/field_source.hpp>
#include <impact/run/setup.hpp>
#include <impact/solve/coupling.hpp>

/// All that hangs on one mesh: state, problems, integrator, solvers, balances, in the order in which they
/// depend on each other. A start and a restart build it by one call, and so would a change of the mesh.
namespace impact {

/// The rows of the table that the steps of the motion carry along; damage and temperature may be null.
struct StepRows {
  StateRow &u, &v, &a, &mean_rate, &prescribed_velocity;
  const StateRow *phi, *theta;
  explicit StepRows(StateTable& state);
};

// Members beyond twelve: the parts stand side by side for those who drive and watch the run.
struct RunStage {
  /// `kept`: the file of the mesh that a checkpoint holds. Prints what the run is made of. Collective. Throws
  /// UserError.
  RunStage(MPI_Comm comm, const Scenario& scenario, std::optional<GmshFile> kept);
  RunStage(const RunStage&) = delete;
  RunStage& operator=(const RunStage&) = delete;

  /// The state at t = 0, or that of a checkpoint, in the table and in the integrator; all rows are there.
  /// Collective.
  void set_state(const Checkpoint* resume);
  /// Forces, accelerations and energies at t = 0, or as a checkpoint has them. Collective.
  void start();
  void resume();

  /// The solvers' part of the hooks around a step.
  StepHooks hooks();
  /// A user's expression may lack a value at the nodes of some ranks alone: tried out where all of them can
  /// agree. Collective.
  void check_prescribed_data(const Attempt& attempt);
  /// Takes the step over that the integrator has accepted, up to the commit of the table.
  /// Velocity and acceleration `with_ghosts` where someone writes fields or columns; explicit steps do
  /// without else. Collective.
  void accept(const Attempt& attempt, bool with_ghosts = true);
  /// Lets those who keep something for cells know which are there, after the table has changed; the mass of
  /// cells goes where it is told to. dt: length of the step. Collective.
  void follow_erosion(Vec u_now, double dt);
  void shed_mass(Vec u_now, double dt);
  /// A resumed run builds its list of candidates afresh and factors anew: so does one that has written a
  /// checkpoint, or they would part by round-off.
  void forget_what_a_restart_lacks();
  /// Between runs with and without a path. Collective.
  void enter_or_leave_path(const Checkpoint& from);

  const Scenario& scenario;
  std::unique_ptr<Setup> setup;
  const Discretisation& d;
  StateTable& state;
  StepRows rows;
  bool inertia;
  SolverDefaults solver;
  Erosion erosion;
  MotionProblem motion;
  std::optional<DamageProblem> damage;
  std::optional<HeatProblem> heat;
  Handle<TS> ts;
  Coupling coupling;
  Ledger ledger;
  FieldSource source;
  Handle<Vec> u, v, a;
  Handle<Vec> before;        ///< work space of `accept`
  bool other_scheme = false; ///< the checkpoint is of a run with another -ts_type
  bool other_forces = false; ///< or of one with contacts that are no more: accelerations jump
};

} // namespace impact
