#pragma once
#include <impact/contact/contact_set.hpp>
#include <impact/mesh/agreed_error.hpp>
#include <impact/problem/body_load.hpp>
#include <impact/problem/force_balance.hpp>
#include <impact/problem/foundations.hpp>
#include <impact/problem/mass_matrix.hpp>
#include <impact/problem/settings.hpp>
#include <impact/problem/soft_volume.hpp>
#include <optional>
#include <string>

/// Balance of momentum of all bodies: residual, tangent and their parts (105)-(106).
///   R(u) = M a + F_int(u; phi frozen, history committed) - F_ext(u, t) - s F_contact(u; lambda, eps)
///        + (s - 1) Y_n
/// A pure function of its arguments and of the step's frozen state: it stores nothing.
namespace impact {

/// A cell for a message, with the number that makes it one; material -1: none.
struct MarkedCell {
  double value = 0;
  double x[3] = {0, 0, 0};
  int material = -1;
};

struct MotionFields;
struct CellBatch;

/// What a stable step goes by: the stiffest cell alone, strained the way that it resists most; or all that
/// cells together allow.
enum class CellsOfStep { stiffest, together };

/// The step that led to a displacement, as bulk viscosity knows it.
struct StepBefore {
  const std::vector<double>& u_n;
  double dt;
  BulkViscosity bulk;
};

/// What one attempt of a step holds fixed. Local arrays with ghosts.
struct MotionStep {
  double t_n = 0, t = 0, dt = 0;
  const std::vector<double>* u_n = nullptr;
  const std::vector<double>* phi = nullptr;     ///< frozen damage of this pass, null without damage
  const std::vector<double>* theta = nullptr;   ///< frozen temperature of this pass, null without heat
  const std::vector<double>* warming = nullptr; ///< what that temperature belongs to (Warming), or null
  ForceShare contact;                           ///< its scale alpha_m/(2 beta) where stabilised, else 1
  double unilateral_scale = 1;                  ///< the same for the unilateral stress of broken points
  /// ForceShare's Y of that stress, minus force, where it acts over the step as a whole; else null.
  const std::vector<double>* unilateral_carried = nullptr;
  bool stabilised = false; ///< the contact-stabilised update
  double mass_shift = 0;   ///< factor of the mass in the tangent, 1/s^2; 0 where none is made
  BulkViscosity bulk;      ///< counts where `advance` finds forces, too
  /// Dashpots feel the velocity slope u + offset, [node][dim]; null: none.
  double velocity_slope = 0;
  const std::vector<double>* velocity_offset = nullptr;
};

/// Where MotionProblem::advance leaves what the heat balance takes from the motion (HeatFeed): arrays like
/// point rows of the state table.
struct HeatRows {
  std::vector<double>* dissipation = nullptr; ///< one component
  std::vector<double>* stress = nullptr;      ///< stress_size components, for the step to come
  /// For this step, whose work is that of the mean of `stress` at its start and this: `stress` and, of the
  /// stress that acts over the step as a whole, twice.
  std::vector<double>* step_stress = nullptr;
};

/// Forces at an accepted state, for reactions and the ledger (global vectors, fixed rows included).
struct ForceParts {
  Handle<Vec> internal, external, contact;
  Handle<Vec> unilateral; ///< of m tau-, which `internal` then lacks; null where it acts like the rest
  Handle<Vec> damping;    ///< of dashpots, part of `external`; null without any
  double sprung = 0;      ///< energy of springs under this rank's facets, per unit thickness
};

/// What mass scaling did.
struct MassScaling {
  double added = 0, share = 0; ///< mass, and its part of that of all bodies
  int cells = 0;
};

// Members beyond twelve: what is given at construction, and the work arrays of three evaluations. Functions
// beyond twenty: it is also the door to what it was given.
class MotionProblem {
public:
  /// `rigid` may be null: no rigid bodies. Without `solved` bodies stay where they are: nothing but the
  /// diagonal stands in the matrix. Throws UserError(usage) for rigid bodies with a contact operator that is
  /// a shell.
  MotionProblem(const Discretisation& discretisation, StateTable& state, const BoundaryData& boundary,
                ContactSet& contacts, bool symmetric_tangent,
                ContactOperator contact_operator = ContactOperator::assembled,
                MatrixFormat format = MatrixFormat::aij, RigidBodies* rigid = nullptr, bool solved = true);

  /// Fixes the step's data: loads at time t are evaluated once here.
  void begin(const MotionStep& step);
  /// Runs what evaluates data of the step and does not communicate. A UserError that it throws on some ranks
  /// only is thrown on all of them: at once, in explicit steps by the `advance` that follows. Collective.
  template <class Body> void evaluate(Body&& body) {
    if (d_.lumped_mass)
      data_errors_.note(body);
    else
      agree_on_errors(d_.mesh.comm(), body);
  }
  /// What parts of an explicit step have to sum up or to compare over the ranks: until `advance` with what
  /// the cells have, and after it until the step is booked.
  Tally& tally() { return tally_; }
  const MotionStep& step() const { return step_; }
  /// How forces and tangents take bodies that hardly change their volume, within a solve.
  SoftVolume& soft_volume() { return soft_volume_; }
  /// SoftVolume::stiffen at u, and foretell for a step from u to `end`.
  void stiffen(Vec u, double part);
  void foretell(Vec u, Vec end);
  /// Displacement that a part of the problem saw last, [node][dim] with ghosts.
  const std::vector<double>& last_displacement() const { return u_; }

  /// f = R(u), zero on prescribed dofs. a: acceleration at t_{n+1}, or null without inertia. Returns false on
  /// all ranks when a cell lost its meaning anywhere. Collective.
  bool residual(Vec u, Vec a, Vec f);
  /// Tangent of R with mass_shift times the mass; prescribed rows and columns carry the mean diagonal.
  /// Collective.
  bool tangent(Vec u, double mass_shift);
  /// Bulk tangent, with the contact in it unless the contact operator is a shell: what a preconditioner sees.
  Mat matrix() const { return assembly_->matrix(); }
  /// The operator of the linear system: matrix(), or a shell that adds the contact to it without assembling.
  Mat jacobian() const { return shell_ ? shell_.get() : matrix(); }

  /// Imposes the prescribed values of time t on u, and on rigid bodies the nearest rigid motion. Collective.
  void impose(Vec u) const;
  /// Rebuilds contact candidates near u; true when the matrix was replaced by one with another pattern.
  /// Collective.
  bool update_contact(Vec u);
  /// Contacts find their surfaces where cells have left. Collective.
  void expose_contacts(Vec u);

  /// Evaluates the law at the accepted u into the trial halves of "history" and "drive". Collective.
  struct Increments {
    double plastic_dissipation = 0, viscous_dissipation = 0, plastic_work = 0;
    double least_dissipation = 0;                   ///< at a point per volume, at most 0
    std::vector<double> plastic_part, viscous_part; ///< of the dissipations, of each material
  };
  /// `internal`: the internal force, bulk viscosity among it, or null. False on all ranks when a cell lost
  /// its meaning anywhere.
  bool advance(Vec u, Increments& sums, const HeatRows& heat = {}, Vec internal = nullptr);
  /// Cells of this rank that the last evaluation of forces found without volume, and that may leave for it
  /// (Erosion::remove): where any rank has some, what it found is of no use.
  const std::vector<std::size_t>& inverted() const { return inverted_; }

  /// Into `change`: how the internal force at u changes where damage, [local node], goes from the step's to
  /// this. Collective.
  void damage_force(Vec u, const std::vector<double>& phi, Vec change);

  /// Parts of the residual at u, prescribed rows included. Collective.
  void parts(Vec u, ForceParts& parts);
  /// Of these the external forces alone without those of foundations, into a vector that is made where there
  /// is none. Collective.
  void loads(Vec u, Handle<Vec>& external);
  /// Adds the foundations' to them, at last_displacement; without `dashpots` those are left to be found.
  /// Collective.
  void add_foundations(ForceParts& parts, bool dashpots);
  void mass_multiply(Vec x, Vec y) { mass_.multiply(x, y); }
  void mass_solve(Vec b, Vec x) { mass_.solve(b, x); }
  /// Of a discretisation with lumped mass, at each dof.
  Vec lumped_mass() { return mass_.lumped(); }
  void forget_mass() {
    mass_.forget();
    shares_.reset();
  }
  /// The longest step of central differences that is stable at u; infinite without deformable bodies.
  /// Collective.
  double stable_step(Vec u, const StepBefore& before, CellsOfStep by);
  /// By which cell: "x=(0,1) in material a"; empty before it was asked for. Collective.
  std::string slowest_cell() const;
  /// The row, a factor at each point, becomes what cells need for a stable step of at least `wanted`; mass
  /// and kinetic energy are with it from now on. Body forces act on the true mass. Collective.
  const MassScaling& scale_mass(Vec u, const StepBefore& before, CellsOfStep by, double wanted,
                                StateRow& factors);
  /// The same with factors that are there. Collective.
  const MassScaling& use_mass(const StateRow& factors);
  const MassScaling& mass_scaling() const { return scaling_; }

  /// Projection of a predictor on the admissible set: residual shift M (w - u_tilde) + s R_contact(w) and its
  /// tangent, which takes the place of the motion's in matrix(). Collective.
  void projection_residual(Vec w, Vec u_tilde, double shift, Vec f);
  void projection_tangent(Vec w, double shift);
  /// The owned rows of nodes on whose diagonal the last tangent has more than the cells put there.
  /// Collective.
  Handle<IS> stiffened_rows() const;

  const Discretisation& discretisation() const { return d_; }
  const BoundaryData& boundary() const { return boundary_; }
  const Foundations& foundations() const { return foundations_; }
  ContactSet& contacts() { return contacts_; }
  const ContactSet& contacts() const { return contacts_; }
  /// Empty where there are none.
  RigidBodies& rigid() { return *rigid_; }
  /// Which cell broke most, of all ranks: "cell inverted (J=-2) at x=(0,1) in material a"; empty without any.
  /// Collective.
  std::string broken_text() const;
  /// 1e-12 E h^(dim-1) of the softest material, or k h^dim of softer springs below: the absolute tolerance
  /// that makes sense for the residual, beside the rounding of stiffer bodies (ForceBalance).
  double reference_force() const { return reference_force_; }
  /// When the residual is balanced; its rounding is that of the last tangent.
  ForceBalance& balance() { return balance_; }

private:
  /// Whether its points have a history: what flows, and the thickness of sheets.
  bool keeps_history(const PointLaw& law) const { return law.flows() || d_.frame == Frame::plane_stress; }
  MotionFields step_fields(const std::vector<double>& u, const std::vector<double>* accel,
                           const PointLaw& law) const;
  bool add_cells(const std::vector<double>& u, const std::vector<double>* accel, double unilateral,
                 std::vector<double>& r);
  void add_pressures(const std::vector<double>& u, double sign, std::vector<double>& r);
  const FacetTable& live_facets(const LoadedFacets& load);
  void add_pressure_tangent(const std::vector<double>& u);
  void add_dashpots(const std::vector<double>& u, double sign, std::vector<double>& r);
  void forget_broken();
  int note_inverted(const CellBatch& batch, const CellStatus& status);
  MarkedCell mark(const CellGroup& group, int batch, int lane, double value) const;
  std::string place_of(const MarkedCell& cell) const;
  bool check_cells(const CellGroup& group, int batch, int bad, const Batch& min_J);
  bool step_cells(const CellBatch& batch, const MotionInput& in, Batch* history, Batch* drive, StepSums& sums,
                  const HeatFeed& heat);
  bool sum_up(bool sound, double least, Increments& sums);
  void put(const std::vector<double>& local, Vec force) const;
  PatchFields patch_fields(const std::vector<double>& u, double unilateral) const;
  void share(const std::vector<double>& u, double unilateral, PatchState& patches,
             bool pressures = false) const;
  std::vector<Batch> find_shares() const;
  template <class Visitor>
  void visit_frequencies(Vec u, const StepBefore& before, CellsOfStep by, Visitor&& visitor);
  void rebuild_matrix();
  void close_tangent(Vec u, bool loads, double diagonal, double mass_shift);
  void multiply(Vec x, Vec y);
  void make_shell();

  const Discretisation& d_;
  StateTable& state_;
  const BoundaryData& boundary_;
  ContactSet& contacts_;
  RigidBodies no_bodies_;
  RigidBodies* rigid_;
  bool symmetric_, solved_;
  ContactOperator operator_;
  MatrixFormat format_;
  MotionRows rows_;
  MassMatrix mass_;
  MassScaling scaling_;
  RankErrors data_errors_;
  Tally tally_;
  std::vector<double> lost_; // of `advance`
  StateRow& history_;
  StateRow* drive_; // null where nothing reads it
  MotionStep step_;
  std::unique_ptr<SparseAssembly> assembly_;
  std::vector<double> X_, u_, v_, a_, r_; // local work arrays [node][dim]
  std::vector<double> dead_load_;         // of the step's time, body forces included
  BodyLoad body_load_;
  Foundations foundations_;
  SoftVolume soft_volume_;
  PatchState patches_;                   // of the evaluation at work, as step_fields has them
  std::vector<CellGroup> matrix_groups_; // cells and patches, where there are patches or rigid bodies
  const std::vector<CellGroup> no_groups_;
  MarkedCell broken_; // the one with the smallest J of those that lost their meaning in an evaluation
  std::optional<std::vector<Batch>> shares_; // of find_shares, once they are asked for
  MarkedCell slowest_;                       // by which steps of central differences are as short as they are
  std::vector<std::size_t> inverted_;
  FacetTable live_load_;
  double reference_force_ = 0;
  ForceBalance balance_;
  Handle<Vec> carried_; // (s - 1) Y_n of all that acts over the step; null where s = 1
  Handle<Vec> cells_diagonal_, diagonal_;
  Handle<Mat> shell_;         // with ContactOperator::shell
  Handle<Vec> linearised_at_; // where the shell's contact tangent is taken
};

} // namespace impact
