#pragma once
#include <impact/problem/motion.hpp>
#include <impact/solve/step_record.hpp>
#include <vector>

/// The forces that the motion solves balanced and their work over a step: a force's mean over both ends times
/// the displacement, but for what acts over the step as a whole (theory.md, 11). Per unit thickness of a
/// plane problem.
namespace impact {

/// Work of the velocity's projection at the start of a step, times the thickness.
struct ShockWork {
  double contact = 0, supports = 0, rigid = 0; ///< rigid: of what keeps rigid bodies rigid
};

struct StepWork {
  double internal = 0;   ///< the bodies' stress does it against them
  double external = 0;   ///< of loads and supports, as means of both ends
  double over_step = 0;  ///< of supports, the part that acts over the step as a whole
  double rigid = 0;      ///< supports of rigid bodies do it
  double contact = 0;    ///< on the bodies
  double unilateral = 0; ///< the unilateral stress of broken points does it
  double left = 0;       ///< of what Newton's method left of the balance
  double inertia = 0;    ///< of what stands for inertia in a run without
  double damping = 0;    ///< of dashpots, part of `external`
  double sprung = 0;     ///< what springs of foundations store at the end of the step
  double jumps = 0;      ///< energy that contacts lost as places came to face something else (78'')
  ShockWork shock;
  IntegratorEnergy integrator; ///< what the scheme itself does
};

/// Forces at t_n are rows of the state table, those at t_{n+1} their trial halves.
// Members beyond twelve: a row for each kind of force, and what an explicit step works with.
class ForceBook {
public:
  /// Adds the rows. References must outlive the book.
  ForceBook(MotionProblem& motion, StateTable& state, bool inertia);

  /// Forces of the start: the half of the first step's work, dt long, that belongs to it; those of contact
  /// are as in their row. `moving`: the state is that of a run with inertia before. Returns what the
  /// integrator holds then. Collective.
  double start(const Integrator& integrator, double dt, Vec u, Vec a, bool moving = false);
  double sprung() const { return sprung_; } ///< StepWork::sprung at the start
  /// After a restart: reactions are not known before the next step.
  void resume();
  /// Books a step while rows still hold t_n; `kept` is IntegratorEnergy::kept of the last one. What waits in
  /// the tally of the motion goes along with the sums. Collective.
  StepWork book(const StepRecord& step, Vec u, Vec v, Vec a, double kept);
  /// The same of a step by central differences whose forces are those at MotionProblem::last_displacement:
  /// one loop over the nodes, one reduction.
  StepWork book_explicit(const StepRecord& step, Vec a);
  /// -dt^2/8 a.Ma, what a step of central differences holds, by the mass that is there now, which later
  /// bookings take too. Not times the thickness. Collective.
  double kept(double dt, Vec a);

  /// These forces close the balance of momentum on prescribed dofs, [node][dim].
  const std::vector<double>& reactions() const { return reactions_; }

private:
  double kept_by_nodes_of_bodies(double dt, Vec a, Vec Ma) const;
  ShockWork find_shock(const StepRecord& step) const;
  IntegratorEnergy find_integrator_energy(const StepRecord& step, Vec u, Vec v, Vec a, double kept);
  Handle<Vec> free_part(Vec of) const;
  void take_over_forces(const StepRecord& step, std::vector<double>& corrected);
  double book_bodies(const StepRecord& step, Vec u, Vec v);
  std::vector<double> close_balance(const StepRecord& step, const std::vector<double>& corrected);
  double mean_work(const std::vector<double>& du, const StateRow& row) const;
  bool in_rigid_body(std::size_t dof) const;

  MotionProblem& motion_;
  const StateRow &u_, &v_, &a_;
  bool inertia_;
  StateRow &internal_, &external_, &contact_, &inertia_force_, &left_;
  StateRow& a_before_; ///< acceleration a step before that of the row "a"
  StateRow* closing_;  ///< of the unilateral stress (StepRecord::closing_at_end); null without
  StateRow* damping_;  ///< of dashpots; null without
  double sprung_ = 0;
  std::vector<double> reactions_;
  std::vector<double> a_new_, mass_;       // of book_explicit
  std::vector<double> over_step_, hidden_; // StepRecord's; zero where nothing acts over the step
};

} // namespace impact
