#pragma once
#include <impact/petsc/handle.hpp>
#include <impact/problem/motion.hpp>
#include <impact/solve/arc_length.hpp>
#include <impact/solve/loose_bodies.hpp>
#include <impact/solve/newton_hooks.hpp>
#include <impact/solve/solver_defaults.hpp>
#include <petscts.h>

/// Newton's method for the motion at a given phi and theta: SNES `motion_` on
///   R(u, a(u)) = 0,   K du = -R,   K = dR/du + mass_shift M        (105), (106)
/// with a(u) from the integrator of the TS. Where an iterative linear solver of ours fails, factors take its
/// place from that step on (row `motion_factors`). It takes the first iteration of a step at its guess, keeps
/// a factorised tangent while that serves, and where iterates go in circles tries once more with
/// augmentations in the place of semismooth multipliers, and with backtracking (theory.md, 7).
namespace impact {

// Members beyond twelve: collaborators, vectors, and what is counted of a solve and of an attempt. More
// functions than usual: a step asks for guess, entry, solve and second solve one by one.
class MotionSolver {
public:
  struct Counts {
    PetscInt newton = 0, linear = 0; ///< of the attempt
    PetscInt longest = 0;            ///< iterations of the longest solve of the step, refused tries included
    PetscInt hardest = 0;            ///< tangents of the hardest solve of the attempt
    long second_ways = 0;            ///< solves of this run that were tried once more
  };
  /// The references must outlive the solver, but for `settings`. Throws UserError(usage). Collective.
  MotionSolver(TS ts, MotionProblem& motion, const SolverDefaults& defaults, const CouplingScenario& settings,
               StateTable& state);

  /// Forgets what another attempt left, matrix factors among it: a resumed run has none from there.
  void begin_attempt(PetscInt number);
  /// u with the prescribed values, and the contact candidates near it. Collective.
  Handle<Vec> imposed(Vec u);
  /// The norm of the forces that are left at u with the prescribed values; infinite where a cell has no
  /// volume. Collective.
  PetscReal left_at(Vec u);
  PetscReal atol() const; ///< -motion_snes_atol, or its default
  /// Takes u, the guess of a step, to `goal`, its prescribed values; where worth while by an iteration. Along
  /// a path that ArcLength finds instead, and false where none leads on. Collective.
  bool enter_step(Vec u, Vec goal);
  /// Lets loose bodies that face nothing yet stride towards what the search sees. Collective.
  void approach(Vec u);
  /// Solves from u in at most so many iterations and, if a second way is worth it, another way. Collective.
  SNESConvergedReason solve(Vec u, Aim aim, PetscInt most_iterations, bool second_way = true);
  /// Back to where the last solve started. Collective.
  void restart(Vec u);
  /// Brings the contact candidates near u; true when that changed the matrix. Collective.
  bool refresh_contact(Vec u);
  /// Hands the motion's present matrix to the solver; needed when the candidates changed outside a step.
  void refresh_matrix();
  /// Drops lagged factors. Collective.
  void forget_factors();

  SNES snes() const { return snes_; }
  NewtonHooks& hooks() { return hooks_; }
  TangentReuse& reuse() { return reuse_; }
  LooseBodies& loose() { return loose_; } ///< empty with inertia
  const ArcLength* arc_length() const { return arc_ ? &*arc_ : nullptr; }
  PetscInt most_iterations() const;
  const Counts& counts() const { return counts_; }
  /// A cell lost its meaning in the last solve.
  bool cell_broke() const { return cell_broke_; }
  /// The residual that the last solve left.
  Vec left() const;

  Mailbox& mailbox();

private:
  void residual(SNES, Vec u, Vec f);
  void tangent(SNES, Vec u, Mat, Mat);
  SNESLineSearchType line_search() const;
  void install_hooks();
  bool enter_path(Vec u);
  void choose_reuse();
  void use_factors(bool use);
  bool fall_back_on_factors();
  bool take_longer_than_factors(PetscInt iterations);
  bool may_take_factors() const;
  void take_factors(const std::string& cause);
  bool first_iteration(Vec u, Vec ahead, double part);
  void add_jump(Vec u, Vec ahead, double part, Vec r);
  bool linear_step(Vec u, Vec r, Vec step);
  SNESConvergedReason newton(Vec u, PetscInt most);
  void watch(bool on);
  SNESConvergedReason other_ways(Vec u, PetscInt most);
  SNESConvergedReason backtrack(Vec u, PetscInt most);
  bool has_second_way() const;
  bool balanced(Vec u);
  bool leaves_unstable() const;
  void leave_unstable(Vec u, PetscInt most);
  bool go_down(Vec u, Vec direction);
  SNESConvergedReason first_way(Vec u, PetscInt most);
  int patience() const;
  SNESConvergedReason by_stages(Vec u, PetscInt most);
  void begin_again(Vec u);

  TS ts_;
  MotionProblem& motion_;
  LooseBodies loose_;
  TangentReuse reuse_{0};
  NewtonHooks hooks_;
  std::optional<ArcLength> arc_;
  Handle<SNES> snes_;
  SolverDefaults defaults_;
  CouplingScenario settings_;
  StateRow& factors_; // 1: in the place of the iterative solver
  bool by_factors_ = false;
  double products_for_factors_ = 0; // 0: not known
  Handle<Vec> residual_, start_;
  PetscReal rtol_ = 0; // as the options say
  Counts counts_;
  PetscInt tangents_ = 0, iterations_ = 0; // of one solve, both its ways
  PetscInt number_ = 1;                    // of the try
  bool second_way_first_ = false;          // in the next try of a step
  bool cell_broke_ = false;
};

} // namespace impact
