#pragma once
#include <impact/mesh/rigid_reduction.hpp>
#include <impact/mesh/state_table.hpp>
#include <impact/petsc/handle.hpp>
#include <impact/problem/boundary_conditions.hpp>
#include <impact/problem/discretisation.hpp>
#include <string>
#include <vector>

/// Meshed rigid bodies (`-material_<id>_model rigid`; theory.md, rigid bodies). Their nodes keep
/// displacement, velocity and acceleration like all others; what is solved for are translation and rotation
/// of each body. Displacements are those of a rotation, to rounding; velocities and accelerations are affine
/// in the reference place, as the integrator's formulas make them.
///
/// Let m_I, y_I be the sums of the consistent mass against 1 and against the reference arm Y. For any nodal
/// field, sum m_I f_I = int rho f and sum f_I y_I^T = int rho f Y^T: every sum over a body below is one over
/// its owned nodes, and a reduction.
namespace impact {

struct RigidBody {
  std::string name;  ///< the material's id, with a number where it has several bodies
  double mass = 0;   ///< of plane bodies per unit thickness; volume where the material has no density
  Vector3 centre{};  ///< of mass, in the reference configuration
  Matrix3 second{};  ///< int rho Y Y^T; 1 in the unused corner of a plane body
  double length = 1; ///< radius of gyration
  int component = 0; ///< its number in find_bodies
  /// Condition that prescribes a translation 0..2 or rotation 3..5, `free_motion` or, where the frame of
  /// the problem allows none, `not_possible`.
  std::array<int, 6> held{};
  static constexpr int free_motion = -1, not_possible = -2;
};

/// Where a body stands.
struct RigidPose {
  Vector3 moved{};              ///< displacement of the centre of mass
  Matrix3 turned = unit_matrix; ///< rotation from the reference configuration
};

/// Force, and moment about the centre of mass; or velocity and angular velocity.
using RigidVector = std::array<double, 6>;

struct RigidMotionState {
  RigidPose pose;
  RigidVector velocity{};
  Vector3 spin{}; ///< angular momentum about the centre of mass; plane: per unit thickness
};

// Members and functions beyond the usual: where nodes, masses and conditions of all bodies are, and one
// question each that a solve, a step or a balance asks of them.
class RigidBodies {
public:
  /// No bodies.
  RigidBodies() : reduction_(2) {}
  /// Finds the bodies of all rigid materials and what the conditions prescribe of them. Throws
  /// UserError(data): a rigid region shares nodes with a deformable one, a body without extent, a condition
  /// that says different things of one component (at t = 0 or t_end; require_agreement looks between),
  /// rotations of deformable groups.
  /// Collective.
  RigidBodies(const Discretisation& discretisation, const std::vector<BoundaryCondition>& conditions,
              double t_end);
  /// Adds the row "rigid": of each body the angle (plane) and the reactions of prescribed motion.
  void declare_state(StateTable& table);

  /// Throws UserError(data) when two conditions move a component of a body differently in a step from t_n to
  /// t. Alike on all ranks.
  void require_agreement(double t_n, double t) const;

  bool empty() const { return bodies_.empty(); }
  const std::vector<RigidBody>& bodies() const { return bodies_; }
  const std::vector<int>& body_of_node() const { return body_of_node_; } ///< [local node], -1: deformable
  const RigidReduction& reduction() const { return reduction_; }
  /// Pairs of nodes that stand for the unknowns of each body.
  std::vector<std::pair<PetscInt, PetscInt>> couplings() const;
  /// Owned local dofs without a row of their own in the linear systems.
  const std::vector<int>& idle_dofs() const { return idle_; }

  /// Projects initial displacements and velocities, local [node][dim], on those of rigid bodies in the norm
  /// of the mass; prescribed components take their values at t = 0. Collective.
  void set_initial(double dt, std::vector<double>& u, std::vector<double>& v) const;
  /// Start of an attempt from t_n to t. u_n: local [node][dim]; `dynamic`: test functions belong to the
  /// middle of the step, else to its end. Collective.
  void begin(double t_n, double t, const std::vector<double>& u_n, bool dynamic);

  /// Whether test functions belong to the middle of the step from now on, or to its end.
  void test_in_the_middle(bool middle) { dynamic_ = middle; }

  /// The nearest admissible displacement: rigid, with prescribed components. Collective.
  void retract(Vec u) const;
  /// On the nodes of bodies u becomes to + u - from.
  void put_change(Vec u, Vec from, Vec to) const;
  /// Zero on all other nodes.
  void keep_bodies_only(Vec f) const;
  /// Forces of a residual at u, f [node][dim], with `acceleration` (local, or null) also inertia, become
  /// those on the unknowns of the bodies, zero where these are prescribed. Collective.
  void reduce(Vec u, Vec f, const std::vector<double>* acceleration = nullptr);
  /// Change of the unknowns about u becomes that of the nodes. Collective.
  void expand(Vec u, Vec du);
  /// At u: inertia and the turning of the arms of the forces that the last `reduce` with `acceleration` saw,
  /// by MatSetValues; the caller assembles. Comes before the tangents of contacts, whose reduction to the
  /// bodies' unknowns is that of the last u. `symmetric`: of that the symmetric part, and test functions of
  /// the middle of the step on both sides. Collective.
  void add_tangent(Vec u, double mass_shift, Mat K);
  /// Trial functions take the place of the test functions, so that contact tangents stay symmetric.
  void use_symmetric_tangent(bool symmetric) { symmetric_ = symmetric; }

  /// [body] force and moment about the centre of mass of forces that `reduce` has reduced: zero where
  /// prescribed. Collective.
  std::vector<RigidVector> resultants(Vec f) const;
  /// Adds to K the mass of a body at the last u, times `factor`; the caller assembles. Not collective.
  void add_mass(std::size_t body, double factor, Mat K) const;

  /// a = (affine acceleration by the forces f, [node][dim]) on the nodes of bodies. Collective.
  void accelerate(Vec f, Vec a) const;
  /// gain = rate of the rigid motion per impulse, on the nodes of bodies, by impulses f [node][dim] whose
  /// arms are those of the start of the attempt, or of the last turn_arms; prescribed components gain
  /// nothing. Collective.
  enum class ArmsAt { start, end };
  void strike(Vec f, Vec gain, ArmsAt at = ArmsAt::start) const;
  /// Arms become those of an evaluation at u. Collective.
  void place(Vec u);
  /// On the nodes of bodies v becomes the part of it that is a rigid rate of their free components, with the
  /// arms of the last evaluation: the rest is across all those in the norm of the mass. Collective.
  void keep_free_rates(Vec v) const;
  /// Prescribed components of the velocity v on bodies that stand as in the last evaluation become those of
  /// the data at the end of the attempt, momenta of free ones stay; `change`: what v changed by. Collective.
  void move_as_told(Vec v, Vec change) const;
  /// Power of the reactions that keep prescribed components as they are while forces f strike; u, v of the
  /// start of the attempt. Collective.
  double strike_power(Vec f, Vec u, Vec v) const;
  /// Reactions of prescribed components, into the trial half of the row, by forces f on the nodes: those that
  /// act, with the other sign; in a dynamic attempt what momenta gained in it less what acts in the mean, of
  /// which free components take their part. Returns their work in the attempt, without inertia with the mean
  /// of both ends; that of `beside`, which adds to the reactions, is left out. After begin. Collective.
  double book_reactions(Vec u, Vec f, Vec beside);
  const double* reactions(int body) const; ///< of the row's trial half: [6]
  /// Largest angle between the poses at two displacements, and the body that it is of. Collective.
  std::pair<double, std::size_t> most_turned(Vec from, Vec to) const;
  /// After an accepted step: the angle of plane bodies. Collective.
  void advance(Vec u);
  /// For the history. Collective.
  std::vector<RigidMotionState> motion(Vec u, Vec v) const;
  double angle(int body) const; ///< of a plane body, turns counted

  /// For steps that find no displacement (solve/explicit_bodies.hpp): nodes that this rank owns, their first
  /// entry in an owned vector and their reference arm.
  struct OwnedNode {
    int row;
    std::size_t body;
    Vector3 arm;
  };
  std::vector<OwnedNode> owned_nodes() const;
  /// What holds a component of a body's motion: nothing; or zero, or data over t of a place or a rate.
  struct Hold {
    bool held = false, rate = false;
    const Expression* data = nullptr;
  };
  Hold hold(const RigidBody& body, std::size_t component) const;
  /// All components of the rotation are prescribed, as rotations from the reference configuration.
  bool turns_as_told(const RigidBody& body) const;
  /// A bound of 1/m + (motion across a force at X by its moment), X a reference place [dim]; 0 where a body
  /// moves as told.
  double give(std::size_t body, const double* X) const;
  /// Arms of the contacts' forces on a body.
  void turn_arms(std::size_t body, const Matrix3& turned) { reduction_.bodies()[body].trial = turned; }
  /// Reactions of a body, of the row's trial half: [6]; the angle of a plane one, which grows by `turn`.
  double* booked(std::size_t body) { return &row_state_->trial[7 * body + 1]; }
  void book_angle(std::size_t body, double turn) {
    row_state_->trial[7 * body] = row_state_->committed[7 * body] + turn;
  }

private:
  // Sums over a body's nodes of f m and f y^T, or of f and f Y^T.
  struct Sums {
    Vector3 sum{};
    Matrix3 moment{};
    void add(const Sums& other) {
      for (std::size_t k = 0; k < 3; ++k) sum[k] += other.sum[k];
      for (std::size_t k = 0; k < 9; ++k) moment[k] += other.moment[k];
    }
  };
  enum class Weight { mass, one };
  template <class Value> std::vector<Sums> sums(Weight weight, Value&& value) const;
  std::vector<Sums> mass_sums(const std::vector<double>& field) const; ///< local [node][dim]
  std::vector<Sums> sums_of(Weight weight, Vec f) const;
  std::vector<RigidPose> poses(const std::vector<Sums>& of_u) const;
  /// u = field(body, reference arm) on the nodes of bodies.
  template <class Field> void set_nodes(Vec u, Field&& field) const;
  /// Spin of the free components by a moment, J being the inertia; no other turns.
  Vector3 free_spin(const RigidBody& body, Matrix3 J, Vector3 moment) const;
  /// rate = rigid rates by impulses with these sums, of bodies with arms (arms(body) Y).
  template <class Arms> void set_free_rates(const std::vector<Sums>& total, Arms&& arms, Vec rate) const;
  /// Of a body's unknowns which component it is, 0..5.
  std::size_t component_of(int unknown) const { return unknown == 2 && dim_ == 2 ? 5 : at(unknown); }
  /// visit(entry of an owned vector, unknown, component) for the unknowns of a body that are on this rank.
  template <class Visit> void visit_unknowns(std::size_t body, Visit&& visit) const {
    for (int r = 0; r < dim_ + reduction_.rotations(); ++r)
      if (const int row = slot_row_[body][r < dim_ ? 0 : 1]; row >= 0)
        visit(row + r % dim_, r, component_of(r));
  }
  void add_block(std::size_t body, double mass, const Matrix3& turn, Mat K) const;
  RigidPose admissible(std::size_t body, RigidPose pose) const;
  Hold hold_by(int condition, std::size_t component) const;
  Vector3 rotation_data(const RigidBody& body, double t) const;
  RigidVector told_rates(const RigidBody& body) const;
  Vector3 arm(std::size_t place) const;
  void find_nodes(const Discretisation& d);
  void weigh(const Discretisation& d);
  void resolve(const Discretisation& d, double t_end);
  void choose_slots(const Discretisation& d);

  MPI_Comm comm_ = MPI_COMM_NULL;
  int dim_ = 2;
  Frame frame_ = Frame::plane_strain;
  std::vector<BoundaryCondition> conditions_;
  std::vector<RigidBody> bodies_;
  std::vector<int> body_of_node_;
  struct Shared {
    std::size_t body, component;
    int first, other; // conditions
  };
  std::vector<Shared> shared_; // components that two conditions prescribe
  RigidReduction reduction_;
  // Nodes of bodies on this rank, ghosts last: local node, body, first entry in an owned vector.
  std::vector<int> node_, body_, row_;
  std::size_t owned_ = 0;
  std::vector<double> X_;            // [place][dim]
  std::vector<double> mass_, first_; // [owned place], [owned place][dim]: m_I and y_I
  std::vector<int> idle_;
  std::vector<std::array<int, 2>> slot_row_; // in an owned vector, -1: elsewhere
  StateRow* row_state_ = nullptr;
  bool dynamic_ = false, symmetric_ = false;
  double t_n_ = 0, t_ = 0;
  std::vector<RigidPose> start_, now_;
  std::vector<Sums> forces_; // of the last residual, for its tangent alone
};

} // namespace impact
