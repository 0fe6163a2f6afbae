#pragma once
#include <array>
#include <impact/contact/enforcement.hpp>
#include <impact/contact/form.hpp>
#include <impact/contact/surface_row.hpp>
#include <memory>
#include <vector>

/// The gap constraints of one contact in an attempt at a step: what its form finds, with gaps and gradients
/// from where the step takes them (step_rule.cpp), no slip where supports hold both sides, and the pressure
/// of the enforcement. All parts of the contact visit the constraints through here; more functions and
/// members than usual, because what a visit brings depends on the form, the step, the supports and the
/// enforcement.
namespace impact {

/// Where a step takes gaps and gradients (theory.md, motion in time).
enum class StepRule {
  none,       ///< gaps and gradients of the displacement itself: at rest, without inertia
  exact_work, ///< energy-conserving: both along the gradients at the middle of the step
  middle,     ///< stabilised: gaps of the end along the gradients at the middle
  start       ///< the projection of its velocity: linear gaps with the gradients of the start
};

class Constraints {
public:
  /// Mesh and layout must outlive it. `mean_length`: of the secondary facets.
  Constraints(const Mesh& mesh, const FieldLayout& layout, std::unique_ptr<ContactForm> form,
              double mean_length, bool frictional);
  Constraints(const Constraints&) = delete;
  Constraints& operator=(const Constraints&) = delete;

  ContactForm& form() { return *form_; }
  const ContactForm& form() const { return *form_; }
  const ContactNodes& nodes() const { return form_->nodes(); }
  MPI_Comm comm() const { return mesh_->comm(); }
  double mean_length() const { return mean_length_; }
  std::size_t dim() const { return dim_; }
  std::size_t tangents() const { return dim_ - 1; } ///< tangential numbers per constraint
  std::size_t dof(int node, std::size_t component) const {
    return dim_ * static_cast<std::size_t>(node) + component;
  }
  /// Whether a dof of nodes() is prescribed, and the flags of a node.
  bool fixed(std::size_t dof) const { return fixed_here_[dof] != 0; }
  const char* fixed_flags(int node) const { return &fixed_here_[dof(node, 0)]; }

  /// `count` constraints, one row per node where `nodal`; `gap` the row of followed gaps of the
  /// energy-conserving update, else null.
  void declare(std::size_t count, bool nodal, StateRow* gap);
  /// Penalties of explicit steps: `left`, [constraint] two numbers, says what they leave between steps
  /// (78'').
  void leave_jumps(SurfaceRow left) { left_ = std::move(left); }
  SurfaceRow release_left() { return std::move(left_); }
  /// Before the first of them: whatever overlaps presses.
  void begin_jumps();
  /// Pressures are those of this enforcement from now on.
  void press_by(const EnforcementMethod& enforcement) { law_ = &enforcement; }
  /// Nodes whose dofs are prescribed; see ContactInterface. Collective.
  void set_fixed_dofs(const std::vector<char>& fixed);
  /// Those flags, for constraints that take the place of these.
  Handle<Vec> release_fixed() { return std::move(fixed_); }
  void take_fixed(Handle<Vec> fixed) { fixed_ = std::move(fixed); }
  /// The form has other nodes. Collective.
  void fetch_fixed();
  void keep_symmetric(bool symmetric) { symmetric_ = symmetric; }

  /// An attempt begins at u_n, where the rigid body has `moved` since; null: nothing is known. Collective.
  void begin(StepRule rule, Handle<Vec> u_n, const std::array<double, 3>& moved);
  /// The u_n that the last attempt was given, for the next one.
  Handle<Vec> release_start() { return std::move(step_.u_n); }
  StepRule rule() const { return step_.rule; }
  void set_rule(StepRule rule) { step_.rule = rule; }
  /// The step is accepted.
  void end();
  /// Once pairs are up to date. Collective.
  void find_start_gaps();
  bool conserving() const { return gap_ != nullptr; }
  bool works_exactly() const { return step_.rule == StepRule::exact_work; }
  /// Gaps at u, the end of an accepted step, are followed from there on. Collective.
  void keep_gaps(Vec u);
  /// How much deeper than at the start of the attempt any constraint lies at u; see ContactInterface.
  double closed_within_step(Vec u, double least) const;
  /// Where the gradients of the step are taken.
  std::vector<double> place_of_gradients(const ContactValues& u) const;

  /// All constraints that face something at the displacement u of nodes(); those that are not `wanted` may be
  /// left out.
  void visit(const ContactValues& u, Derivatives derivatives, const ConstraintVisitor& visitor,
             const ConstraintFilter& wanted = {}) const;
  void visit(Vec u, Derivatives derivatives, const ConstraintVisitor& visitor,
             const ConstraintFilter& wanted = {}) const {
    visit(nodes().displacement(u), derivatives, visitor, wanted);
  }
  /// Those that press, which is what forces need, or did as springs that may be lost.
  ConstraintFilter pressing() const {
    return [this](int index, double gap) { return law_->presses(index, gap) || pressed(index); };
  }
  /// Of this rank, in the step whose forces are known: energy of springs that have no constraint any more,
  /// less what pushing out the overlap that was left gave (78'').
  double taken_by_jumps() const;
  /// Second variations over the same constraints, as the step takes them; factors are used up.
  void visit_curvature(const ContactValues& u, std::vector<double>& of_gap, std::vector<Tangential>& of_slip,
                       const BlockVisitor& visitor) const;
  /// Values [constraint][component] reach all ranks that hold the node of a constraint. Collective.
  void share(std::vector<double>& values, std::size_t components) const;
  std::size_t count() const { return count_; }
  /// 1 for each constraint that is this rank's own, else 0.
  std::vector<double> owned() const;

private:
  struct Step {
    StepRule rule = StepRule::none; // until the step is accepted
    Handle<Vec> u_n;                // where the attempt starts
    std::array<double, 3> moved{};
    std::vector<double> start;     // of nodes(): u_n, relative to the rigid body where it will be
    std::vector<double> start_gap; // by constraint
    bool finds_jumps = false;
    mutable std::vector<double> given; // by constraint, energy
  };
  std::vector<double> relative_start() const;
  void keep_overlap(Constraint& c) const;
  double way_within_step(const ContactValues& u, const Constraint& c) const;
  bool pressed(int index) const;
  void remember_springs();
  double jump(const ContactValues& u, const Constraint& c) const;
  void leave_jump(const ContactValues& u, Derivatives derivatives, Constraint& c) const;
  void visit_step(const ContactValues& u, Derivatives derivatives, const ConstraintVisitor& visitor) const;
  void visit_followed(const ContactValues& u, Derivatives derivatives,
                      const ConstraintVisitor& visitor) const;
  void hold_slip(const ContactValues& u, Constraint& c, std::vector<double>& gradient) const;

  const Mesh* mesh_;
  const FieldLayout* layout_;
  std::unique_ptr<ContactForm> form_;
  std::size_t dim_, count_ = 0;
  double mean_length_;
  bool frictional_, nodal_ = false, symmetric_ = false;
  const EnforcementMethod* law_ = nullptr;
  StateRow* gap_ = nullptr;
  SurfaceRow left_;
  Handle<Vec> fixed_;            // 1 at fixed dofs; absent: none
  std::vector<char> fixed_here_; // [node][dim] of the form's nodes
  bool supported_ = false;       // some secondary node of a form with a constraint per node is
  Step step_;
};

} // namespace impact
