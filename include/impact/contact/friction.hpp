#pragma once
#include <impact/contact/constraints.hpp>
#include <impact/contact/surface_row.hpp>

/// Coulomb friction of one contact, |t| <= mu p, with the trial traction q = t_old + eps s of the step
/// (82') (theory.md, contact; coulomb.hpp). Its spring is that of the enforcement. Its rows of the state
/// table: the traction that a step starts from, and the slip since a constraint closed with its state.
/// What comes free as a surface changes has no place in these rows: it keeps no spring, t_old = 0, and tells
/// what the last step did alone.
namespace impact {

/// More functions and members than usual: force, tangent, the enforcement, heat and output each ask for their
/// part of it.
class Friction {
public:
  /// State of a constraint in the last component of the row "slip".
  static constexpr double sticks = 1, slides = 2;

  Friction() = default; ///< there is none
  Friction(double coefficient, StateRow& traction, StateRow& slip)
      : coefficient_(coefficient), traction_(traction), slip_(slip) {}

  bool acts() const { return static_cast<bool>(traction_); }
  /// `iterated`: steps solve for equilibrium; else the forces of both of their ends do work, by halves.
  void press_by(const EnforcementMethod& enforcement, bool iterated) {
    law_ = &enforcement;
    iterated_ = iterated;
  }
  /// Leaves it out for a while.
  void suspend(bool suspended) { suspended_ = suspended; }
  /// The surface has changed (SurfaceRow).
  void change_surface(const std::vector<int>& place);
  bool changed() const { return traction_.changed(); }
  /// The traction that a report shows: of the present state, or of the last step.
  Tangential shown(const Constraint& c) const;
  /// Whether it acts on this constraint now.
  bool rubs(const Constraint& c) const { return acts() && !suspended_ && c.slides && c.active; }
  /// The traction that the trial value starts from.
  Tangential held(const Constraint& c) const;
  Traction traction(const Constraint& c) const;
  /// Coulomb's law as the next linear solve takes it (follow).
  Traction linear_traction(const Constraint& c) const;
  /// What the next step starts from.
  Tangential traction_to_keep(const Constraint& c) const;
  /// Change of the traction of a rubbing constraint by its slip, the change by the gap left out.
  std::array<Tangential, 2> slip_stiffness(const Constraint& c, const Traction& t) const;
  /// Adds the energy that a constraint turned into heat in the step: w t.s, without what a penalty keeps
  /// elastically, or lets go.
  void add_heat(const Constraint& c, double& heat) const;
  double coefficient() const { return coefficient_; }
  /// How often since the start of the run a constraint closed again, on average over those that ever pressed.
  /// Collective.
  double reopenings(MPI_Comm comm) const;
  /// The traction at the end of a linear solve, where the pressure is lambda and the slip s.
  Tangential after_linear_solve(const Constraint& c, double lambda, const Tangential& slip) const;
  /// What a linear solve lacks in the residual, per direction: of a method that closes gaps, what makes the
  /// slip vanish that must, with `gap_force` its stiffness times the gap; else what sticks for it alone.
  Tangential missing(const Constraint& c, double gap_force) const;

  /// No way of sliding is remembered: Newton's method starts.
  void forget();
  /// At every iterate of Newton's method: what slid in the linear solve that led to u and would slide the
  /// other way there sticks in the next one, or the method jumps to and fro between two states that slide in
  /// opposite directions. True on all ranks when the next linear solve needs a matrix of its own. Collective.
  bool follow(const Constraints& constraints, Vec u);
  /// Whether anything sticks so in the linear solve at the last iterate: its step closes what sticks, and
  /// only if it is taken in full. Equal on all ranks.
  bool reverses() const { return reverses_; }

  /// [constraint][direction] tractions of the trial half; new ones are kept unless friction is suspended.
  const std::vector<double>& tractions() const { return traction_->trial; }
  std::vector<double>& given() { return acts() ? traction_->trial : none_; }
  void keep_tractions(std::vector<double>& tractions);
  /// At the end of a step: what the next one starts from, of every constraint that acts, which a visit tells.
  void begin_end();
  void note_end(const Constraint& c);
  /// The step is accepted. Collective.
  void advance(const Constraints& constraints);
  /// The constraints that press, or keep a spring.
  ConstraintFilter acting() const;
  /// Slip since the constraint closed, [direction], and its state.
  const double* slip(const Constraint& c) const {
    return &slip_->trial[(tangents() + 1) * static_cast<std::size_t>(c.index)];
  }
  double state(const Constraint& c) const { return slip(c)[tangents()]; }

private:
  StepTraction step_traction(const Constraint& c) const;
  Tangential traction_in(const std::vector<double>& tractions, const Constraint& c) const;
  std::size_t tangents() const { return static_cast<std::size_t>(traction_->components); }

  bool forgets(const Constraint& c) const { return traction_.lacks(c.index); }

  double coefficient_ = 0;
  const EnforcementMethod* law_ = nullptr;
  SurfaceRow traction_, slip_;
  std::vector<double> none_;
  bool iterated_ = true, suspended_ = false, reverses_ = false;
  // [constraint] direction of sliding in the linear solve that led to the iterate, and in the one to come;
  // zero where it sticks, or no solve was yet. Both begin with every Newton solve.
  std::vector<Tangential> slid_, slides_;
  std::vector<char> kind_;
  std::vector<double> next_traction_, next_slip_; // of the step that ends, as the rows
  std::vector<int> closed_;                       // [constraint] how often, since the start of the run
};

} // namespace impact
