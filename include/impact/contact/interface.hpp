#pragma once
#include <array>
#include <impact/contact/friction.hpp>
#include <impact/contact/rigid_nodes.hpp>
#include <impact/petsc/tally.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

/// One contact between two surfaces, R_c(w) = sum w (t.ds[w] - p dg[w]) with the pressure p and Coulomb's
/// traction t (theory.md, contact). Its parts: the form finds gap constraints, Constraints brings them as a
/// step takes them, an EnforcementMethod makes pressures of gaps, Friction tractions of slips. The force at a
/// displacement depends on rows of the state table, of which evaluations read the trial half, and on what the
/// form's last update fixed: nothing is stored by an evaluation.
namespace impact {

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

/// What a contact does to the energies in the step that ended at a displacement, times the thickness.
struct ContactStep {
  double energy = 0; ///< stored there, as ContactMeasures say
  /// Turned into heat by sliding: sum w t.s, without what a penalty keeps elastically.
  double friction_loss = 0;
  /// Of the energy-conserving update, else 0: energy in contact that was neither given back nor turned into
  /// heat, because its constraints face nothing any more (over an edge). Negative where constraints begin
  /// with an overlap.
  double released = 0;
  /// Of a moving rigid body on the bodies: its motion times the force of the step, and that of the shock at
  /// the start.
  double obstacle_work = 0, obstacle_shock = 0;
};

/// A place at which heat passes a contact in one step. Per unit thickness.
struct HeatPath {
  double conductance = 0;    ///< h dA, power per temperature
  double friction = 0;       ///< heat that sliding made in the step
  std::size_t secondary;     ///< nodes on the secondary side, which come first; a rigid body has none
  std::vector<int> node;     ///< into ContactInterface::nodes()
  std::vector<double> share; ///< sum 1 on either side
};

/// Overlap of the undeformed surfaces at the secondary nodes.
struct InitialOverlapReport {
  int nodes = 0;      ///< nodes that must be moved (setting adjust), over all ranks
  double deepest = 0; ///< largest overlap found
  std::vector<double>
      shift; ///< [local node][dim] stress-free shift of reference coordinates, ghosts included
};

/// What contacts ask of the solution of the motion; it may change between the solves of a step.
struct ContactDemands {
  bool closes_gaps = false; ///< multipliers are updated within Newton's method
  bool augments = false;    ///< they are updated between its solves
  bool frictional = false;
  bool reverses = false; ///< something sticks for the next linear solve alone (Friction::follow)
};

/// How a step takes the force F of contact, which moves the bodies as if it acted over all of it (theory.md,
/// S1 to S3). Y is the contact's part of mass times acceleration, Y_n at the start.
struct ForceShare {
  double scale = 1, alpha_m = 1, gamma = 0.5;
  double over_step = 0; ///< part of F - Y_n that acts over the step as a whole; not 0: Y becomes F
  /// What balances the other forces at the end: scale F - (scale - 1) Y_n less what acts over the step.
  double at_end(double F, double Y_n) const { return over_step != 0 ? F : scale * F - (scale - 1) * Y_n; }
  /// Y at the end.
  double carried(double F, double Y_n) const { return (at_end(F, Y_n) + (alpha_m - 1) * Y_n) / alpha_m; }
  /// What the bodies gain of momentum, over dt.
  double impulse(double F, double Y_n) const {
    return Y_n + gamma * (carried(F, Y_n) - Y_n) + over_step * (F - Y_n);
  }
};

/// How far the sides are from pressing each other.
struct ContactReach {
  double gap = 0;      ///< smallest one, infinite where nothing faces
  double distance = 0; ///< of the nearest nodes among the search's pairs, where nothing faces
  /// Of flat sides, of which a quarter or more presses or would touch at once: that area, else 0; and the
  /// stiffness of the penalties there.
  double touches = 0, stiffness = 0;
  Vector3 opens{}; ///< the secondary side's way, at any length, that opens the places that touch first
  bool presses = false;
};

/// Sums over the constraints at the end of a step, of this rank or of all, not times the thickness.
struct ContactSums {
  double energy = 0, heat = 0;   ///< ContactStep's, as `friction_loss`
  double held = 0, spring = 0;   ///< energies of springs at the ends of a step whose work is exact
  std::array<double, 3> force{}; ///< on the secondary side
  double force_times_way = 0;    ///< minus twice the work on the bodies
  std::span<double> numbers() { return {&energy, sizeof *this / sizeof(double)}; }
};

/// At the dofs of each node i, the sum over the active constraints of w eps |dg_i| sum_j |dg_j|: no
/// eigenvalue of the penalties' stiffness, over the masses of the nodes, is larger than the largest of these
/// over them. Nodes of a rigid body count as one, whose sum goes into `of_bodies`; |dg_i| is there that by
/// translation and rotation, in the norm of inertia over mass. Further how deep this rank's active
/// constraints lie, of what is seen.
struct StiffnessBound {
  Vec of_nodes;
  std::vector<double>& of_bodies; ///< [rigid body]
  double deepest = 0;
  std::vector<double> size = {}; ///< work: |dg_i| of one constraint
};

/// More functions and members than usual: the face of one contact towards the solution of a step, the heat
/// that passes it, the ledger and the output, in front of the parts that do the work. What concerns one part
/// alone is asked of that part. Functions that take a Vec, and those that say so, are collective.
class ContactInterface {
public:
  /// Mesh and layout must outlive the interface; rows `contact_<id>_multiplier`, `_penalty`, `_totals`,
  /// `_force`, `_carried`, `_left`, with friction `_traction` and `_slip`, are added to the table, and the
  /// candidates at u = 0 are found. Throws UserError: unknown groups, a penalty that is not positive,
  /// automatic without a modulus, a rigid body without a direction or radius. Collective.
  ContactInterface(const Mesh& mesh, const FieldLayout& displacement, const ContactSettings& settings,
                   const ContactEnvironment& environment, StateTable& state);
  ContactInterface(const ContactInterface&) = delete; // its parts know each other
  ContactInterface& operator=(const ContactInterface&) = delete;

  const std::string& id() const { return settings_.id; }
  /// Settings with every automatic value replaced by its number.
  const ContactSettings& settings() const { return settings_; }
  /// Sentences for the user: primary facets shorter than the spacing of the points. Equal on all ranks.
  const std::vector<std::string>& warnings() const { return warnings_; }
  Constraints& constraints() { return *constraints_; }
  const Constraints& constraints() const { return *constraints_; }
  const ContactNodes& nodes() const { return constraints_->nodes(); }
  PairSearch& search() { return constraints_->form().search(); }
  const PairSearch& search() const { return constraints_->form().search(); }
  /// Of explicit steps: the longest that penalties are made for, over the present one.
  void set_longest_step(double steps) { constraints_->form().set_longest_step(steps); }
  /// Nodes of rigid bodies, [local node] a body of `reduction` or -1: their part of the tangent goes to the
  /// unknowns of their bodies. The reduction is kept, and asked for the state at hand by every add_tangent.
  /// Collective.
  void set_rigid_nodes(const RigidReduction& reduction, const std::vector<int>& body);

  /// Whether there were forces at the end of the last step; and whether the penalty alone made them, without
  /// multipliers. Collective.
  bool bears() const;
  bool rests_on_penalty() const;
  /// Energy that the contact gives where multipliers that stay let go: their pressure ends at an opening by
  /// it over the penalty. Collective.
  double held_by_multipliers(Vec u) const;
  /// The penalty at hand, and another one from here on, of explicit steps; at the depth `stiffens_at` its
  /// pressure is twice that of a linear one, 0: never.
  double penalty() const { return method().eps(); }
  void set_penalty(double penalty, double stiffens_at) {
    for (std::vector<double>* half : {&rows_.penalty->committed, &rows_.penalty->trial}) {
      (*half)[EnforcementRows::value] = penalty;
      (*half)[EnforcementRows::stiffens_at] = stiffens_at;
    }
  }

  /// Beginning of an attempt that ends at t: where the rigid body's motion is taken. The committed row `u`
  /// of the table, where there is one, says where the bodies start. `mass_shift` (1/s^2) is the factor of the
  /// mass in the tangent, 0 without inertia: an automatic penalty of an augmented Lagrangian is raised to 2.5
  /// rho h mass_shift for the attempt. `stabilised`, with inertia: until advance forces stand along the
  /// gradients at the middle of the step, the gaps being those of its end. Collective.
  void set_time(double t, double mass_shift = 0, bool stabilised = false, const ForceShare& share = {});
  /// The projection of the velocity of a stabilised attempt begins or ends: gaps are linear in between, with
  /// the gradients of the start, an overlap of the start counts as touch, friction is left out, and
  /// multipliers start from zero; they and the penalty are put back.
  void begin_projection();
  void end_projection();
  /// The projection ended at w: the step takes half its force, its impulse over dt.
  void keep_shock(Vec w);

  /// Cells have left their bodies ([cell point minus cell_start] 1): both sides are made anew of what is
  /// there and of the facets inside their bodies that came free, and searched at u. For penalties at Gauss
  /// points; facets that were there at the start keep their rows (SurfaceRow). Collective.
  void expose(const std::vector<char>& eroded, Vec u);
  /// One that the run before did not have begins at t: its obstacle moves from where it is then. Throws
  /// UserError(data) where its sides overlap at u, but for -contact_<id>_initial allow. Collective.
  void begin_at(double t, Vec u);
  /// Facets of a side, a boundary, as they are now.
  FacetTable facets(const std::string& side) const;

  /// Brings the candidate pairs up to date and lets the form fix what must not change while Newton's method
  /// works; true on all ranks when the set of pairs, hence the matrix pattern, changed.
  bool update_search(Vec u);
  /// Pairs of global nodes that the candidates of this rank may couple, sorted, each once.
  NodePairs couplings() const;
  /// How often the nodes were found anew.
  long searches() const { return searches_; }

  /// r += scale f, f = -int p dg dA_0 (a residual: minus the force on the bodies).
  void add_residual(Vec u, double scale, Vec r) const { add_residual(u, scale, r, constraints_->pressing()); }
  /// r += scale times minus what of the present acceleration, times the mass, is the contact's.
  void add_carried(double scale, Vec r) const;
  /// A run begins from this state at the acceleration by all forces, those of contact among them.
  void carry_force();
  /// K += scale df/du by MatSetValues; the caller assembles. Symmetric unless something slides, or in a step
  /// whose forces stand along the gradients at its middle.
  void add_tangent(Vec u, double scale, Mat K) const;
  /// y += scale (df/du) du without a matrix.
  void multiply(Vec u, double scale, Vec du, Vec y) const;

  ContactDemands demands() const;
  /// Before the next solve, where bodies are `loose`: held by contact alone. `first_touch`: some press
  /// nothing so far, and penalties take the place of a method that closes gaps. Where points are far more
  /// than the surfaces' nodes, which pressures are left is a choice among many; there augmentations do.
  void meet(bool loose, bool first_touch);
  /// Of an automatic penalty, as long as the bodies do not rest on it.
  void scale_penalty(double factor) {
    if (settings_.automatic_penalty) rows_.penalty->trial[EnforcementRows::value] *= factor;
  }
  /// Where nothing presses yet and `goal`, the start of a step with its supports where they end, lies deep,
  /// the step begins with soft springs.
  void ease(Vec goal);
  /// A solve begins; then the multipliers that it began with and those of its iterates change places, of a
  /// method that makes some of iterates.
  void keep_multipliers();
  void swap_multipliers();
  /// For the rest of the attempt an augmented Lagrangian takes the place of a method that closes gaps, whose
  /// active set did not come to rest.
  void fall_back();
  /// Before Newton's method starts from u: constraints that touch take part in its first iteration, and no
  /// way of sliding is remembered.
  void start_newton(Vec u);
  /// After its step du from u, which ended at `next`: multipliers of the linearised system, and with `follow`
  /// what slides (Friction::follow).
  SetChange after_newton_step(Vec u, Vec du, Vec next, bool follow);
  /// r += scale times what the right-hand side of a linear solve holds beside the residual, zero on fixed
  /// dofs: gamma sum w g dg over the active constraints, so that the solution closes the gaps; for other
  /// methods what sticks for this solve alone.
  void add_gaps(Vec u, double scale, Vec r) const;
  /// Active gaps, and slips that must vanish, at u.
  GapsLeft gaps_left(Vec u, double force = std::numeric_limits<double>::infinity()) const {
    return method().gaps_left(*constraints_, friction_, u, force);
  }

  /// Forgets the gap that the penalty rule compares with: first call of each Uzawa loop.
  void start_augmentation();
  /// What augment would do, without doing it.
  AugmentReport review(Vec u) const;
  /// lambda <- <lambda - eps g> for every constraint, 0 where it faces nothing, as the method has it.
  AugmentReport augment(Vec u);

  /// The step from u_n ends at u: force, unless it is null, loses what add_residual would add, and in the
  /// same visit of the constraints it is found what `step` and `advance` will ask for, once `tally` has been
  /// reduced. Collective.
  void end_step(Vec u_n, Vec u, Vec force, StiffnessBound* bound, Tally& tally);
  /// A dof of this rank that the contact may push: its place among those of a global vector here, and in a
  /// local array.
  struct ReachedDof {
    PetscInt place;
    std::size_t local;
  };
  /// All of them, at the end of the last step: what concerns a contact need not pass over a whole mesh.
  const std::vector<ReachedDof>& reached() const { return reached_; }
  /// After an accepted step: impulse and work of the step into the trial totals, by the trapezoidal rule; of
  /// a stabilised step the momentum gained, and the work of the force at its end. A call with u_n = u and dt
  /// = 0 before the first step records the force of the start. Ends the step if that has not been done; else
  /// u_n is not asked for, and may be null.
  void advance(Vec u_n, Vec u, double dt);
  /// Before advance.
  ContactStep step(Vec u) const;

  /// Whether explicit steps find its pressures (impulses.hpp), and where those go: [constraint], and
  /// [constraint][direction] of tractions, of the trial halves.
  bool by_impulse() const { return method().is_given(); }
  std::vector<double>& given_pressures() { return rows_.multiplier->trial; }
  std::vector<double>& given_tractions() { return friction_.given(); }
  /// Of what rubs (Friction::reopenings). Collective.
  double reopenings() const { return friction_.reopenings(mesh_->comm()); }

  bool frictional() const { return settings_.friction > 0; }
  /// Whether heat may pass it.
  bool passes_heat() const { return settings_.conductance > 0 || frictional(); }
  /// Where heat passes in the step that ends at u: at the places where the forces stand, through what presses
  /// or touches now. The sum of the frictional heat over all ranks is the friction_loss of the step over the
  /// thickness. Before advance.
  std::vector<HeatPath> heat_paths(Vec u) const;
  ContactMeasures measures(Vec u) const;
  /// At the secondary nodes, as weighted means of the constraints. Of `fields`, those of other contacts, a
  /// node keeps the smaller gap, otherwise what is larger; of vectors what is not zero.
  ContactFields nodal_fields(Vec u, ContactFields fields = {}) const;
  ContactReach reach(Vec u) const;

  /// Overlap at u = 0. Throws UserError(data) when it is forbidden (setting error) or deeper than initial_tol
  /// (adjust); overlap of rounding size counts as none. The shift is not applied. Collective.
  InitialOverlapReport initial_overlap();

private:
  using Vector = std::array<double, 3>;
  // The row "totals" by the names of its components; those in front are vectors of dim or three numbers.
  struct Totals {
    double *impulse, *work, *force, *carried, *obstacle, *spring, *heat; // on the secondary side; of the body
  };
  Totals totals(std::vector<double>& half) const;
  bool stabilised() const { return constraints_->rule() == StepRule::middle; }
  // The method at hand, which may be the fallback of the one that was asked for.
  EnforcementMethod& method() const { return fallback_ && falls_back() ? *fallback_ : *method_; }
  bool falls_back() const { return fallen_back_ || by_penalty_ || eased_; }
  void use_method();
  void follow_slip(Vec u);
  void declare_state(StateTable& state);
  void place_obstacle();
  void make_constraints(ContactSurface secondary, const ContactSurface& primary);
  void use_new_nodes(); // of the form
  void find_reached();
  ObstaclePose pose() const;
  void visit_tangent(Vec u, double scale, const BlockVisitor& visitor) const;
  void tangent_block(const Constraint& c, double scale, std::vector<double>& block) const;
  AugmentReport propose(Vec u, std::vector<double>& lambda, std::vector<double>& traction) const;
  Vector add_residual(Vec u, double scale, Vec r, const ConstraintFilter& wanted,
                      const ConstraintVisitor& see = {}) const;
  ConstraintFilter ending() const;
  void add_step(const Constraint& c, ContactSums& sums) const;
  void add_force(const Constraint& c, const Tangential& traction, Vector& force) const;
  void add_stiffness_bound(const Constraint& c, std::vector<double>& stiff, StiffnessBound& bound) const;
  double push_on_body(const Constraint& c, int body) const;
  Vector total_force(Vec u) const;       // on the secondary side, not times the thickness. Collective
  Vector of_the_end(Vector force) const; // of that of a step, likewise
  double spring_energy(double gap, const Tangential& traction) const;
  void add_energy(const Constraint& c, double& energy) const;
  std::unique_ptr<ContactForm> curved_form(Vec at_rest) const;
  void put_obstacle(double t);
  double thickness() const; // what is reported is multiplied by it

  const Mesh* mesh_;
  const FieldLayout* layout_;
  const StateTable* state_;
  ContactSettings settings_;
  ContactEnvironment environment_;
  std::vector<std::string> warnings_;
  Vector outward_{}; // of a round rigid body (pole_of)
  std::optional<Constraints> constraints_;
  Friction friction_;
  std::unique_ptr<EnforcementMethod> method_, fallback_;
  RigidNodes rigid_nodes_;
  EnforcementRows rows_{};
  StateRow *totals_ = nullptr, *force_ = nullptr, *carried_ = nullptr; // by nodes as add_residual has them
  /// What cells that left have made of a side.
  struct LiveSide {
    std::vector<char> body; // [local node] 1 in the bodies of the side
    FacetTable facets;
  };
  std::map<std::string, LiveSide> live_;                 // by boundary; empty as long as no cell has left
  std::array<std::vector<double>, 2> before_projection_; // multipliers, penalty
  std::array<std::vector<double>, 2> before_solve_;      // multipliers, tractions
  ForceShare share_;
  std::optional<ContactSums> end_; // of the step that ended, until it is accepted or another one begins
  Vector shock_{};                 // on the secondary side: impulse of the projection over dt
  Handle<Vec> last_force_;         // at the start of a step whose work is exact
  Handle<Vec> pushed_;             // forces of one visit, else zero
  std::vector<ReachedDof> reached_;
  long reached_after_ = -1;                                      // searches
  double inertia_penalty_ = 0;                                   // over the mass shift
  double last_change_ = std::numeric_limits<double>::infinity(); // of the multipliers, in an augmentation
  double time_ = 0;                                              // of the attempt's end
  double mean_length_ = 0;                                       // of the secondary facets
  long searches_ = 0;
  bool at_rest_ = true, fallen_back_ = false, by_penalty_ = false, eased_ = false;
};

} // namespace impact
