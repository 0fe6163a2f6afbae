#pragma once
#include <impact/mesh/state_table.hpp>
#include <impact/solve/motion_solver.hpp>
#include <impact/time/types.hpp>

/// What impacts change of an integrator's step (theory.md, 7). The contact-stabilised update (P. Deuflhard,
/// R. Krause, S. Ertel, Int. J. Numer. Meth. Engng 73 (2008) 1274) projects the velocity at the start of a
/// step on what contact admits, and lets the contact force F move the bodies as if it acted over the step as
/// a whole (ForceShare):
///   w = arg min |w - u_tilde|_M / 2  over what the gradients of the start admit,   v_n += (w - u_tilde)/dt
///   a -= a_c,  v += dt (2 beta - gamma) a_c   with M a_c = P / (2 beta)
/// P is over_step (F - Y_n), by the trapezoidal rule alone. F is the force of contact and of the unilateral
/// stress of broken points, which acts like one. From rigid bodies the update takes out what keeps them
/// rigid, so that their acceleration is that by the forces, and gives what these cannot move its mean
/// velocity, what data move that of the data.
namespace impact {

class StabilisedUpdate {
public:
  /// `stabilise`: contact is stabilised, with inertia; `unilateral`: there is a unilateral stress, which acts
  /// over the step as a whole in implicit steps with inertia. Adds the row `closing_carried` for it. The
  /// references must outlive the object. Collective.
  StabilisedUpdate(TS ts, MotionProblem& motion, MotionSolver& solver, StateTable& state, bool stabilise,
                   bool unilateral);

  bool stabilised() const { return stabilise_; }
  bool unilateral() const { return unilateral_; }
  bool corrects() const { return stabilise_ || unilateral_ || !motion_.rigid().empty(); }
  /// Factors of the two forces in the balance of the step.
  ForceShare contact_share() const;
  double unilateral_scale() const { return unilateral_ ? integrator_of(ts_).share() : 1; }
  const std::vector<double>* unilateral_carried() const {
    return unilateral_ ? &step_.carried->committed : nullptr;
  }

  /// The hooks of the same names. `contact_force`: F on the bodies at the solution. Collective.
  void predict(const Attempt& attempt, Vec u_tilde, Vec v);
  void correct(Vec contact_force, Vec u, Vec v, Vec a);

  /// In the step that `correct` saw, prescribed dofs included. Of contact on the bodies: ForceShare::at_end.
  Vec contact_at_end() const { return step_.at_end; }
  /// Likewise of the unilateral stress; null where it does not act apart.
  Vec closing_at_end() const { return unilateral_ ? step_.closing.get() : nullptr; }
  /// P; null where nothing acts over a step as a whole.
  Vec over_step() const { return step_.over_step ? step_.over_step.get() : nullptr; }
  /// What supports feel of neither, because it is of this step alone: P - 2 beta M a_c, or at_end - F; null
  /// as P.
  Vec hidden() const { return step_.hidden ? step_.hidden.get() : nullptr; }
  /// A run begins at the acceleration by all forces, among them minus this of the unilateral stress.
  void carry(Vec unilateral);
  /// Impulse over dt that the projection put on the bodies; zero elsewhere.
  Vec shock() const { return step_.shock; }
  /// All that `correct` took out of the acceleration.
  Vec acceleration() const { return acceleration_; }
  /// By what it then changed the velocity of rigid bodies to that of their data.
  Vec told() const { return told_; }
  /// Forces at the end of the step, `unilateral` among them, where that acts apart.
  const ForceParts& forces() const { return forces_; }

private:
  ForceShare share() const;
  void split_step_forces(Vec u, Vec v, Vec a);
  void take_out_over_step(Vec v, Vec a);
  void take_out_rigidity(Vec u, Vec v, Vec a);
  bool project(const Attempt& attempt, Vec goal, Vec u_tilde, Vec v);
  SNESConvergedReason minimise(double dt, Vec goal, Vec w);
  void warn(double t_n, SNESConvergedReason reason);

  TS ts_;
  MotionProblem& motion_;
  MotionSolver& solver_;
  StateTable& state_;
  bool stabilise_, unilateral_;
  bool warned_ = false;
  struct {
    Handle<Vec> at_end, closing, over_step, hidden, shock;
    StateRow* carried = nullptr; // of the unilateral stress
  } step_;
  Handle<Vec> acceleration_, told_;
  ForceParts forces_;
};

} // namespace impact
