#pragma once
#include <algorithm>
#include <impact/contact/settings.hpp>
#include <impact/input/units.hpp>
#include <impact/material/toughness.hpp>
#include <impact/problem/boundary_conditions.hpp>
#include <impact/problem/erosion_rule.hpp>
#include <impact/problem/settings.hpp>
#include <map>
#include <memory>
#include <petscsys.h>

/// Everything one run is told, read once from the options database, complete, validated and printable.
/// Nobody reads our keys after it (PETSc's own objects read theirs under their prefixes).
namespace impact {

struct Group;

enum class PlaneMode { strain, stress, axisymmetric };

/// A number of the user's (`-param_v0`), in run units, a name in every expression.
struct ParameterScenario {
  std::string id;
  double value = 0;
};

/// A table `name(t)` of every expression, from a CSV file.
struct FunctionScenario {
  std::string id;
  std::string file; ///< resolved path
};

struct MeshScenario {
  std::string file;         ///< resolved path
  int order = 0;            ///< of the cells; 0: that of the file
  bool serendipity = false; ///< of second order: no nodes amid quadrilaterals and hexahedra
  double scale = 1;
  int refine = 0;
  double most_cells = 2e6, patience = 600; ///< -mesh_cells, -mesh_wall
  std::map<std::string, std::string> set;  ///< .geo parameters
  std::string convert;                     ///< the file of -mesh_convert; empty: none
};

/// A material as the user describes it, and the law that is made of this when everything has been read.
/// How numbers of a law differ from place to place: factors.
struct PlaceScenario {
  struct Factor {
    std::optional<Expression> expression; ///< of x, y, z
    double weibull = 0;                   ///< modulus of a factor of chance beside it; 0: none
    bool given() const { return expression || weibull > 0; }
  } E, Gc, strength;
  int seed = 1;
  double length = 0; ///< of the cubes that share a number of chance; 0: cells

  bool given() const { return E.given() || Gc.given() || strength.given(); }
};

struct MaterialScenario {
  static constexpr double absent = std::numeric_limits<double>::quiet_NaN();
  std::string id;
  MaterialParameters law;
  std::vector<std::string> regions; ///< physical names; default: the id
  double E = absent, nu = absent, K = absent, G = absent;
  double eos_c0 = absent, eos_gamma = absent;
  double c_v = 0, c_mass = absent; ///< heat capacity per volume, or per mass
  double alpha_t = 0;
  std::vector<std::string> hardening;
  std::string hardening_table;                  ///< resolved path of `points`
  std::shared_ptr<const HardeningTable> points; ///< what law.table points to
  double sigma_y = 0, linear_h = absent, jc_a = absent, rate_0 = absent, theta_ref = absent;
  double strength = absent, strength_ratio = absent, lorentz_p = 1;
  Split split = Split::automatic;
  std::optional<Softening> softening; ///< empty: automatic, and so below
  ErosionRule erosion;
  ToughnessFatigue fatigue;
  ToughnessByState toughness;
  std::string rate_table, temperature_table; ///< resolved paths of `toughness`
  PlaceScenario place;
  std::optional<Locking> locking; ///< automatic: mean for j2 on quads and hexes, else none
  struct Option {
    std::string name, text, said; ///< text: in the run's units; said: the user's words, empty for a default
  };
  std::vector<Option> options;

  bool has_capacity() const { return c_v > 0 || c_mass > 0; }
};

struct OutputScenario {
  std::string id;
  enum class Type { xdmf, csv } type = Type::xdmf;
  std::vector<std::string> fields;
  double dt = 0;  ///< 0: not by time
  int every = 0;  ///< 0: not by steps
  int cycles = 0; ///< at the middle and the end of every so many cycles of -ts_period; 0: not by cycles
  std::vector<double> times;
  std::string file; ///< without directory; default: <id>.xdmf or history.csv
};

struct ProbeScenario {
  std::string id, region; ///< region "" = any
  double at[3] = {0, 0, 0};
  std::vector<std::string> fields;
};

struct MeasureScenario {
  std::string id, on;
  std::vector<std::string> fields;
  enum class Of { mean, min, max, sum } of = Of::mean;
};

/// A ring around the tip of a crack, whose energy release rate is a column.
struct ReleaseScenario {
  std::string id;
  double at[3] = {0, 0, 0};
  double inner = 0, outer = 0;     ///< radii between which the virtual advance falls from 1 to 0
  std::string along = "x";         ///< as the option says it
  double direction[3] = {1, 0, 0}; ///< that, of length 1
  double length = 0;               ///< of a front in space, weighted by the advance; 0: inner + outer
};

/// Ends the run when it holds at the end of a step.
struct StopScenario {
  std::string id, when; ///< a Condition on columns of the history
};

struct TimeScenario {
  std::string type = "newmark"; ///< newmark | static | central_difference
  double dt = 0;                ///< 0: as long as is stable, with central differences
  double max_time = 0;
  double cfl = 0.8;                             ///< largest part of the stable step of the cells
  double bulk_linear = 0, bulk_quadratic = 0;   ///< bulk viscosity of explicit steps
  double scaled_step = 0, scaling_limit = 0.05; ///< mass scaling of explicit steps; 0: none
  double most_substeps = 1e5;                   ///< of damage or heat in a step
  int max_steps = 0;                            ///< 0: no limit
  double period = 0;                            ///< of a cyclic load; 0: none
  std::vector<double> table_times, table_dts;   ///< -ts_times, -ts_dts
  std::map<std::string, double> of_petsc;       ///< given options that the integrator reads itself

  double scale() const { return dt > 0 ? dt : 1e-6 * max_time; } ///< of a step
  double steps() const; ///< of the run if none is cut; without limit where they find their length
};

struct CheckpointScenario {
  std::string dir; ///< default <output_dir>/checkpoints
  int every = 0;
  double wall = 600;
  int keep = 2;
  double patience = 60;
  double walltime = 0;                    ///< seconds of the whole job; 0: no limit
  double walltime_margin = -1;            ///< seconds; -1: a tenth of `walltime`, at most 60
  std::string restart = "none";           ///< none | auto | a file
  std::vector<std::string> restart_allow; ///< guarded options that may differ from the checkpoint's

  double margin() const { return walltime_margin >= 0 ? walltime_margin : std::min(60.0, walltime / 10); }
};

struct ContactScenario : ContactSettings {
  std::array<std::optional<Expression>, 3> rigid_u; ///< displacement of the rigid body over t
  std::array<std::optional<Expression>, 3> rigid_r; ///< rotation of one with mass over t
  double rigid_mass = 0;                            ///< 0: the rigid body moves as told
  double rigid_inertia = automatic; ///< about its centre of mass; automatic: by shape, a plane does not turn
  double rigid_length = 0;          ///< of a cylinder in space, for its inertia
  std::optional<Expression> temperature; ///< of the rigid body over t
};

struct Scenario {
  std::string title, output_dir = ".";
  bool restep = false; ///< every step is tried, refused and tried again with the same dt
  UnitSystem units;
  std::vector<ParameterScenario> params;
  std::vector<FunctionScenario> functions;
  int dim = 0; ///< 0: from the mesh
  PlaneMode plane = PlaneMode::strain;
  double thickness = 1;
  bool overwrite = false, dry_run = false, strict = false;
  MeshScenario mesh;
  std::vector<MaterialScenario> materials;
  std::vector<BoundaryCondition> bcs;
  std::vector<InitialCondition> ics;
  std::vector<ContactScenario> contacts;
  TimeScenario time;
  DamageScenario damage;
  HeatScenario heat;
  std::vector<std::string> physics; ///< of motion, damage, heat; empty: motion, and the others that have data
  CouplingScenario coupling;
  TangentChoice tangent = TangentChoice::automatic;
  std::optional<MatrixFormat> matrix; ///< of motion; empty: as the linear solver wants it
  ContactOperator contact_operator = ContactOperator::assembled;
  std::vector<OutputScenario> outputs;
  std::vector<ProbeScenario> probes;
  std::vector<MeasureScenario> measures;
  std::vector<ReleaseScenario> releases;
  std::vector<StopScenario> stops;
  CheckpointScenario checkpoint;
  double energy_tol = 0.02; ///< of the largest energy; 0: off
  double energy_stop = 0.2; ///< ends the run; 0: never
  enum class EnergyAction { warn, cut, stop } energy_action = EnergyAction::warn;
  double crack_level = 0.9;
  int crack_tips = 1;             ///< cracks of a material whose origins and tips are columns
  bool history_materials = false; ///< energies and dissipations of each material as columns

  bool solves(const std::string& name) const;
  bool has_motion() const { return solves("motion"); }
  bool has_damage() const;
  bool has_heat() const;
  bool any_fatigue() const;
  bool has_inertia() const { return has_motion() && time.type != "static"; }
  bool explicit_steps() const { return has_motion() && time.type == "central_difference"; }
};

/// Whether the volume of the cells is nearly fixed: by plastic flow, or by elastic moduli (nu from 0.45 on).
bool keeps_volume(const MaterialParameters& law);
/// The cure of volumetric locking where the options name none.
Locking automatic_locking(const MaterialParameters& law, PlaneMode plane);

/// Reads and checks everything (closed key set with suggestions, units, ranges, expressions). Collective.
/// Throws UserError(usage) with one line for the first fault, UserError(io) for a file that cannot be read.
/// With -help prints option_help() first, and the run is a dry one. Values of -ts_dt and -ts_max_time with a
/// unit are replaced by plain numbers in the database, because PETSc's TS reads them too.
Scenario read_scenario(MPI_Comm comm);

/// Where checkpoints go when nothing else is said.
std::string default_checkpoint_dir(const Scenario& scenario);

/// The resolved input as the user would type it, one key per line (checkpoints, -dry_run). `as_typed`:
/// materials in the user's own words; checkpoints have numbers.
std::string print_scenario(const Scenario& scenario, bool as_typed = false);
/// The first option whose force has no symmetric derivative, whatever the tangent of the cells is, and what
/// would have one; empty: none.
std::pair<std::string, std::string> unsymmetric_force(const Scenario& scenario);

/// Throws UserError(data) for the first option that names a group which the mesh does not have, or one of the
/// wrong dimension, and for `-dim` and components that do not fit the mesh. No communication; alike on all
/// ranks.
void check_groups(const Scenario& scenario, const std::vector<Group>& groups, int mesh_dim);

/// What may become of an option on a restart.
enum class RestartKey {
  free,    ///< solvers, output, end time, time step: may change
  guarded, ///< what is computed: changes only with -restart_allow
  frozen   ///< mesh, dimension, units: cannot change
};

/// The kind of an option, by its name without dash, from its row. Names without a row are guarded.
RestartKey restart_key(const std::string& name);

/// Compares the options of the run that wrote a checkpoint with those of the run that goes on from it.
/// Returns one line per guarded change that `allow` covers: an entry is the name of an option, or its
/// beginning up to an underscore (bc_push for all of -bc_push_*). Throws UserError(usage) that names key, old
/// and new value for a frozen change, for a guarded one that is not allowed, and for an entry of `allow` that
/// fits no option. Values that are paths are compared by their file names.
std::vector<std::string> check_restart_options(const std::string& stored, const std::string& now,
                                               const std::vector<std::string>& allow,
                                               const std::string& checkpoint);

/// What `-help` prints of our options.
std::string option_help();

/// The option reference page (Markdown), generated from the same tables; `impact -reference` prints it.
std::string option_reference();

} // namespace impact
