#pragma once
#include <algorithm>
#include <array>
#include <functional>
#include <impact/contact/form.hpp>
#include <impact/contact/settings.hpp>
#include <impact/kernel/frame.hpp>
#include <impact/mesh/rigid_reduction.hpp>
#include <impact/mesh/state_table.hpp>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

/// One contact between two surfaces: its form (ContactForm) supplies gap constraints, the
/// interface the enforcement, R_c(w) = sum w (t.ds[w] - p dg[w]) with the pressure p and Coulomb's traction
/// t. The force at a displacement depends on the multipliers, the penalty and what the form's last update
/// fixed: nothing is stored by an evaluation. Multipliers and penalty are rows of the state table;
/// evaluations read the trial half.
namespace impact {

/// What the caller knows and the user's settings do not say.
struct ContactEnvironment {
  Frame frame = Frame::plane_strain;
  double thickness = 1; ///< multiplies what is reported of plane problems
  double modulus = 0;   ///< Young's modulus of the softer undegraded side
  double density = 0;   ///< of the heaviest side where bodies have inertia, else 0
  double length = 0;    ///< cell size beside the surface; 0: mean secondary facet
};

/// What an evaluation saw, on this rank, without a reduction.
struct ContactStatus {
  int active = 0;           ///< active constraints
  double penetration = 0;   ///< largest -g
  bool finite = true;       ///< false: a coordinate is not a number
  bool search_holds = true; ///< false: something moved so far that the candidate list may miss a facet
};

/// What an augmentation changes; equal on all ranks.
struct AugmentReport {
  double penetration = 0; ///< max(-g) over all points
  double largest_gap = 0; ///< max of |g|, at most p / eps, over the points with p > 0
  double multiplier = 0;  ///< largest new multiplier
  double change = 0;      ///< largest change of a multiplier over the largest new one
  double penalty = 0;     ///< the penalty that was used
  int active = 0;
  bool settled =
      true; ///< nothing that presses changed what it faces since the solve, or is too deep to judge
  /// settled, and unless the penalty is all: penetration < gap_tol and change < pressure_tol, or that of the
  /// forces on the nodes where an augmentation did not halve the change
  bool converged = false;
};

/// For the history file. Totals count from t = 0. Plane problems: times the thickness; axisymmetric: the full
/// ring. Vectors of plane problems have a third component of zero.
struct ContactMeasures {
  std::array<double, 3> force{};   ///< on the secondary side
  double gap_min = 0;              ///< nan when no point faces anything
  double pressure_max = 0;         ///< per current area
  double pressure_min = 0;         ///< over the active points, 0 without
  double length = 0;               ///< closed part of the secondary surface: current length or area
  double energy = 0;               ///< potential (p^2 - lambda^2) / (2 eps)
  double work = 0;                 ///< done by the contact forces on the bodies, total
  std::array<double, 3> impulse{}; ///< on the secondary side, total
  int active = 0;
  int sliding = 0;       ///< active constraints that slide against friction
  double dissipated = 0; ///< what their sliding turned into heat, total
};

/// For the field output, [local node][component], ghosts included. Vectors have three components; u: at the
/// end of an accepted step.
struct ContactFields {
  std::vector<double> pressure; ///< per current area; 0 off the surface
  std::vector<double> gap;      ///< nan where nothing is near
  std::vector<double> status;   ///< 0 open, 1 sticks, 2 slides, as all that presses without friction does
  std::vector<double> traction; ///< tangential, on the secondary side, per current area
  std::vector<double> slip;     ///< of the secondary side, since the place closed
};

/// Of a moving rigid body on the bodies in one step: by the forces of the step, by the shock at its start.
struct ObstacleWork {
  double force = 0, shock = 0;
};

/// Places at which heat passes a contact in one step. Per unit thickness.
struct HeatPaths {
  std::vector<double> conductance; ///< [place] h dA, power per temperature
  std::vector<double> friction;    ///< [place] heat that sliding made in the step
  /// [place + 1] into node and share; secondary nodes come before primary ones, of which a rigid body has
  /// none.
  std::vector<std::size_t> first = {0};
  std::vector<std::size_t> secondary; ///< [place] secondary nodes
  std::vector<int> node;              ///< into ContactInterface::nodes()
  std::vector<double> share;          ///< sum 1 on either side

  std::size_t count() const { return conductance.size(); }
};

/// Overlap of the undeformed surfaces at the secondary nodes.
struct InitialOverlapReport {
  int nodes = 0;      ///< nodes that must be moved (setting adjust), over all ranks
  double deepest = 0; ///< largest overlap found
  std::vector<double>
      shift; ///< [local node][dim] stress-free shift of reference coordinates, ghosts included
};

class ContactInterface {
public:
  /// Mesh and layout must outlive the interface; rows `contact_<id>_multiplier`, `_penalty`, `_totals`,
  /// `_force`, with friction `_traction` and `_slip`, are added to the table, and the candidates at u = 0 are
  /// found. Throws UserError: unknown groups, a penalty that is not positive, automatic without a
  /// modulus, a rigid body without a direction or radius. Collective.
  ContactInterface(const Mesh& mesh, const FieldLayout& displacement, const ContactSettings& settings,
                   const ContactEnvironment& environment, StateTable& state);

  const std::string& id() const { return settings_.id; }
  /// Settings with every automatic value replaced by its number.
  const ContactSettings& settings() const { return settings_; }
  /// Sentences for the user: primary facets shorter than the spacing of the points. Equal on all ranks.
  const std::vector<std::string>& warnings() const { return warnings_; }

  /// Beginning of an attempt that ends at t: where the rigid body's motion is taken. The committed row `u`
  /// of the table, where there is one, says where the bodies start. `mass_shift` (1/s^2) is the factor of the
  /// mass in the tangent, 0 without inertia: an automatic penalty of an augmented Lagrangian is raised to 2.5
  /// rho h mass_shift for the attempt. `stabilised`, with inertia: until advance forces stand along the
  /// gradients at the middle of the step, the gaps being those of its end. Collective.
  void set_time(double t, double mass_shift = 0, bool stabilised = false);
  /// The projection of the velocity of a stabilised attempt begins or ends: gaps are linear in between, with
  /// the gradients of the start, an overlap of the start counts as touch, friction is left out, and
  /// multipliers start from zero; they and the penalty are put back.
  void begin_projection();
  void end_projection();
  /// The projection ended at w: impulse and obstacle_work take half its force, the impulse over dt.
  /// Collective.
  void keep_shock(Vec w) { step_.shock = half(total_force(w)); }
  /// Local dofs [node * dim + k] whose rows and columns tangent and multiply leave out; the residual keeps
  /// them, for the reactions. Flags of remote nodes are fetched here and when the candidates change.
  /// Collective.
  void set_fixed_dofs(const std::vector<char>& fixed);
  /// Nodes of rigid bodies, [local node] a body of `reduction` or -1: their part of the tangent goes to the
  /// unknowns of their bodies. The reduction is kept, and asked for the state at hand by every add_tangent.
  /// Collective.
  void set_rigid_nodes(const RigidReduction& reduction, const std::vector<int>& body);

  /// Brings the candidate pairs up to date and lets the form fix what must not change while Newton's method
  /// works; true on all ranks when the set of pairs, hence the matrix pattern, changed. Collective: one
  /// reduction when nothing moved far.
  bool update_search(Vec u);
  /// The next update_search builds the pairs afresh, as a restarted run does.
  void forget_search() { form_->forget(); }
  /// Pairs of global nodes that the candidates of this rank may couple, sorted, each once.
  std::vector<std::pair<PetscInt, PetscInt>> couplings() const;

  /// The same of the nodes themselves, where rigid bodies have no unknowns of their own.
  NodePairs node_couplings() const { return form_->couplings(); }
  const ContactNodes& nodes() const { return form_->nodes(); }
  /// How often the nodes were found anew.
  long searches() const { return searches_; }
  /// Of an attempt from a row `u`: how much deeper than at its start any constraint lies at u, in mean
  /// secondary facets; 0 where that is no more than `least`. Collective: one reduction where nothing lies
  /// that deep.
  double closed_within_step(Vec u, double least) const;

  /// r += scale f, f = -int p dg dA_0 (a residual: minus the force on the bodies). Collective.
  ContactStatus add_residual(Vec u, double scale, Vec r) const;
  /// K += scale df/du by MatSetValues; the caller assembles. Symmetric unless something slides, or in a step
  /// whose forces stand along the gradients at its middle. Collective.
  ContactStatus add_tangent(Vec u, double scale, Mat K) const;
  /// y += scale (df/du) du without a matrix. Collective.
  void multiply(Vec u, double scale, Vec du, Vec y) const;

  /// Tangents are to stay symmetric but for friction, for solvers that need that.
  void keep_symmetric(bool symmetric) { symmetric_ = symmetric; }
  bool frictional() const { return settings_.friction > 0; }
  /// Whether heat may pass it.
  bool passes_heat() const { return settings_.conductance > 0 || frictional(); }
  /// Where heat passes in the step that ends at u: at the places where the forces stand, through what presses
  /// now. The sum of the frictional heat over all ranks is friction_loss over the thickness. Before advance.
  /// Collective.
  HeatPaths heat_paths(Vec u) const;
  /// Energy that sliding turned into heat in the step that ended at u: sum w t.s, without what a penalty
  /// keeps elastically. Before advance. Collective.
  double friction_loss(Vec u) const;
  /// Of the energy-conserving update, else 0: energy in contact that was neither given back nor turned into
  /// heat in the step that ended at u, because its constraints face nothing any more (over an edge). Negative
  /// where constraints begin with an overlap. Before advance. Collective.
  double released_energy(Vec u) const;
  /// Work that a moving rigid body did on the bodies in the step that ended at u: its motion times the force
  /// at the end and that of the shock at its start, or the mean of both ends. Before advance. Collective.
  ObstacleWork obstacle_work(Vec u, bool force_at_end) const;
  /// Whether the multipliers are updated within Newton's method.
  bool semismooth() const {
    return settings_.enforce == Enforcement::semismooth && !fallen_back_ && !by_penalty_;
  }
  /// Before the next solve, where bodies are `loose`: held by contact alone. `first_touch`: some press
  /// nothing so far, and penalties take the place of the semismooth method. Where points are far more than
  /// the surfaces' nodes, which pressures are left is a choice among many; there augmentations do.
  void meet(bool loose, bool first_touch) {
    by_penalty_ = first_touch;
    fallen_back_ = fallen_back_ || (loose && form_->overdetermined());
  }
  /// Whether they are updated between its solves.
  bool augments() const { return settings_.enforce != Enforcement::penalty && !semismooth(); }
  /// For the rest of the attempt an augmented Lagrangian takes the place of the semismooth method, whose
  /// active set did not come to rest.
  void fall_back() { fallen_back_ = true; }
  /// r += scale gamma sum w g dg over the active constraints, zero on fixed dofs: what the right-hand side of
  /// a linear solve holds beside the residual, so that the solution closes the gaps. For other
  /// enforcements what sticks for this solve alone (follow_sliding). Collective.
  void add_gaps(Vec u, double scale, Vec r) const;
  /// Before Newton's method starts from u: constraints that touch take part in its first iteration of the
  /// semismooth method, and no way of sliding is remembered. Collective.
  void start_newton(Vec u);
  /// Without the semismooth method, at every iterate: what slid in the linear solve that led to u and would
  /// slide the other way there sticks in the next one (`reverses`), or Newton's method jumps to and fro
  /// between two states that slide in opposite directions. True on all ranks when the next linear solve needs
  /// a matrix of its own. Collective.
  bool follow_sliding(Vec u);
  /// Whether anything sticks so in the linear solve at the last iterate: its step closes what sticks, and
  /// only if it is taken in full. Equal on all ranks.
  bool reverses() const { return reverses_; }
  /// Multipliers of the linearised system after a full step from u to u + du: lambda - gamma (g + dg.du)
  /// where active at u, else 0. True on all ranks when the active set at u + du is another one. Collective.
  bool take_newton_step(Vec u, Vec du, Vec next);
  /// Active gaps, and slips that must vanish, at u. Collective.
  struct GapsLeft {
    /// To 1e-11 of a facet, and so that closing the rest takes no more than `force` against the penalty at
    /// any constraint, or to rounding of the coordinates. True for other enforcements.
    bool closed = true;
    double open = 0; ///< the largest, over the mean facet
  };
  GapsLeft gaps_left(Vec u, double force = std::numeric_limits<double>::infinity()) const;
  /// What no pressure closes, because there are more constraints than the surfaces can meet, is let off below
  /// this part of a facet.
  static constexpr double most_open = 1e-6;

  /// Whether contact takes part in the energy-conserving update.
  bool conserving() const { return gap_ != nullptr; }

  /// Forgets the gap that the penalty rule compares with: first call of each Uzawa loop.
  void start_augmentation();
  /// What augment would do, without doing it. Collective.
  AugmentReport review(Vec u) const;
  /// lambda <- <lambda - eps g> for every constraint, 0 where it faces nothing, then the penalty grows by
  /// its rule. Pure penalty: nothing changes. Collective.
  AugmentReport augment(Vec u);

  /// After an accepted step: impulse and work of the step into the trial totals, by the trapezoidal rule, or
  /// of the force of a stabilised step. A call with u_n = u and dt = 0 before the first step records the
  /// force of the start. Collective.
  void advance(Vec u_n, Vec u, double dt);
  /// Collective.
  ContactMeasures measures(Vec u) const;
  /// Pairs of the search per secondary facet that has any. Collective.
  double pairs_per_facet() const { return form_->pairs_per_facet(); }
  /// How far the sides are from pressing each other at u. Collective.
  struct Reach {
    double gap = 0;       ///< smallest one, infinite where nothing faces
    double distance = 0;  ///< of the nearest nodes among the search's pairs, where nothing faces
    double stiffness = 0; ///< as long as nothing presses: of the penalty, over the places that touch
    bool presses = false;
  };
  Reach reach(Vec u) const;
  /// At the secondary nodes, as weighted means of the constraints. Collective.
  ContactFields nodal_fields(Vec u) const;

  /// Overlap at u = 0. Throws UserError(data) when it is forbidden (setting error) or deeper than initial_tol
  /// (adjust); overlap of rounding size counts as none. The shift is not applied. Collective.
  InitialOverlapReport initial_overlap();

private:
  // Steps whose forces stand along the gradients at their middle (step_gradient.cpp), and among them the
  // energy-conserving update (conserving.cpp).
  static constexpr double unknown_gap = std::numeric_limits<double>::infinity();
  enum class StepRule {
    none,       // gaps and gradients of the displacement itself: at rest, without inertia
    exact_work, // energy-conserving
    middle,     // stabilised
    start       // the projection of its velocity
  };
  struct Step {
    StepRule rule = StepRule::none; // since set_time, until advance
    std::array<double, 3> shock{};  // on the secondary side: impulse of the projection over dt
    Handle<Vec> u_n, last_force;    // where the attempt starts, and its force there
    std::vector<double> start;      // of nodes(): u_n, relative to the rigid body where it will be
    std::vector<double> start_gap;  // by constraint
    std::vector<double> reach;      // multipliers by which the form brings all constraints that may close
  };
  bool exact_work() const { return step_.rule == StepRule::exact_work; }
  static std::array<double, 3> half(const std::array<double, 3>& a) { return {a[0] / 2, a[1] / 2, a[2] / 2}; }
  // Of nodes(): where the attempt starts, relative to the rigid body where it will be. Collective.
  std::vector<double> relative_start() const;
  void find_start_gaps();
  double kept_overlap(int index) const;
  PressureLaw reaching_law() const;
  // Where the gradients of the step are taken.
  std::vector<double> place_of_gradients(const std::vector<double>& u) const;
  void visit_step(const std::vector<double>& u, Derivatives derivatives,
                  const ConstraintVisitor& visitor) const;
  void visit_followed(const std::vector<double>& u, Derivatives derivatives,
                      const ConstraintVisitor& visitor) const;
  StepTraction step_traction(const Constraint& c) const;
  double contact_stiffness(const Constraint& c) const;
  // Energy of the springs of normal and tangential penalties.
  double spring_energy(double gap, const Tangential& traction) const;
  // The same of all constraints at u, not times the thickness. Collective.
  double spring_energy(Vec u) const;
  void keep_gaps(Vec u);
  double penalty() const { return std::max(penalty_->trial[0], penalty_->trial[2]); }
  PressureLaw law() const;
  bool rubs(const Constraint& c) const { // friction acts on it, now
    return traction_ != nullptr && !friction_suspended_ && c.slides && c.active;
  }
  // Numbers per constraint that are tangential.
  std::size_t tangents() const { return static_cast<std::size_t>(dim_ - 1); }
  Tangential held(const Constraint& c) const; // the traction that a trial value starts from
  Traction traction(const Constraint& c) const;
  // Coulomb's law as the next linear solve takes it (follow_sliding).
  Traction linear_traction(const Constraint& c) const;
  // What the next step starts from.
  Tangential traction_to_keep(const Constraint& c) const;
  // Of a sliding constraint: change of its traction by slip across the direction of the traction.
  double turn_stiffness(const Constraint& c, const Traction& t) const;
  // The same of any rubbing constraint as a matrix, the change by the gap left out.
  std::array<Tangential, 2> slip_stiffness(const Constraint& c, const Traction& t) const;
  // Visits the tangent, df/du times scale, in blocks over the dofs of nodes: what stiffness and friction make
  // of the gradients, then the second variations.
  ContactStatus visit_tangent(const std::vector<double>& u, double scale, const BlockVisitor& visitor) const;
  struct TangentSpace { // kept between constraints
    std::vector<double> block, row;
  };
  void tangent_block(const Constraint& c, double scale, TangentSpace& space) const;
  void add_frictional_heat(const Constraint& c, double& heat) const; // of the step
  void add_force(const Constraint& c, std::array<double, 3>& force) const;
  void keep_tractions(Vec u);
  std::array<double, 3>
  total_force(Vec u) const; // on the secondary side, not times the thickness. Collective
  double reported_thickness() const { return is_flat(environment_.frame) ? environment_.thickness : 1; }
  std::size_t dof(int node, std::size_t component) const {
    return static_cast<std::size_t>(dim_) * static_cast<std::size_t>(node) + component;
  }
  void set_automatic_values(const ContactSurface& secondary, const ContactSurface& primary);
  void declare_state(StateTable& state);
  void use_new_nodes(); // of the form
  void fetch_fixed();
  void hold_slip(const std::vector<double>& u, Constraint& c, std::vector<double>& gradient) const;
  void fetch_bodies();
  ContactStatus add_reduced_tangent(Vec u, double scale, Mat K) const;
  void share(std::vector<double>& values, int components) const;
  std::array<double, 3> obstacle_displacement(double t) const;
  ObstaclePose pose_at(double t) const;
  void find_pole(const ContactSurface& secondary);
  ContactStatus visit(const std::vector<double>& u, Derivatives derivatives,
                      const ConstraintVisitor& visitor) const;
  AugmentReport propose(Vec u, std::vector<double>& lambda, std::vector<double>& traction) const;
  // Largest component of sums at the nodes, [node][dim] of the form's nodes. Collective.
  double largest_of(const std::vector<double>& nodal) const;

  const Mesh* mesh_;
  const FieldLayout* layout_;
  const StateTable* state_;
  ContactSettings settings_;
  ContactEnvironment environment_;
  std::vector<std::string> warnings_;
  std::unique_ptr<ContactForm> form_;
  int dim_;
  std::vector<char> fixed_here_;                                 // [node][dim] of the form's nodes
  double last_change_ = std::numeric_limits<double>::infinity(); // of the multipliers, in an augmentation
  bool supported_ = false; // some secondary node of a form with a constraint per node is
  Handle<Vec> fixed_;      // 1 at fixed dofs; absent: none
  const RigidReduction* reduction_ = nullptr;
  Handle<Vec> body_;           // 1 + rigid body of a node, in its first component; absent: none
  std::vector<int> body_here_; // [node] of the form's nodes, -1: none; empty without rigid bodies
  StateRow *multiplier_, *penalty_, *totals_, *force_;
  StateRow *traction_,
      *slip_; // [constraint][direction], and at the end of slip_ the state; null without friction
  StateRow* gap_ = nullptr; // accumulated gaps of the conserving update, else null
  Step step_;
  std::array<std::vector<double>, 2> before_projection_; // multipliers, penalty
  // [constraint] direction of sliding in the linear solve that led to the iterate, and in the one to come;
  // zero where it sticks, or no solve was yet. Both begin with every Newton solve.
  std::vector<Tangential> slid_, slides_;
  std::vector<char> kind_;
  bool reverses_ = false;
  std::array<double, 3> outward_{}; // from a round rigid body's centre to its pole
  double inertia_penalty_ = 0;      // over the mass shift
  double mean_length_ = 0;          // of the secondary facets
  double time_ = 0;                 // of the attempt's end
  long searches_ = 0;
  bool at_rest_ = true, fallen_back_ = false, by_penalty_ = false, friction_suspended_ = false,
       symmetric_ = false;
};

} // namespace impact
