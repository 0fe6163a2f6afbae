#pragma once
#include <impact/petsc/error.hpp>
#include <impact/problem/motion.hpp>
#include <impact/solve/loose_bodies.hpp>
#include <impact/solve/newton_watch.hpp>
#include <impact/solve/tangent_reuse.hpp>
#include <petscts.h>

/// What Newton's method for displacements does beside its equations, in any SNES over them: multipliers of
/// the semismooth method and sliding follow every iterate before the residual is evaluated there, linear
/// solves close gaps, steps of rigid bodies go from their unknowns to their nodes and back to rotations, and
/// balance, gaps and a watch over cycles say when it ends (theory.md, 7).
namespace impact {

class NewtonHooks {
public:
  /// All must outlive the object; exceptions wait in the mailbox of `ts`.
  NewtonHooks(TS ts, MotionProblem& motion, LooseBodies& loose, TangentReuse& reuse);
  NewtonHooks(const NewtonHooks&) = delete;
  NewtonHooks& operator=(const NewtonHooks&) = delete;

  /// Hooks itself into `snes`, its line search and its KSP, which must outlive neither.
  void install(SNES snes);

  /// How the next solve goes.
  struct Conduct {
    Vec iterate = nullptr;        ///< the vector of the solve, about which linear solves close gaps
    bool goes_on = false;         ///< it goes on from a first iteration: its balance has a start already
    bool follows_sliding = false; ///< what slides to and fro sticks
    bool watched = false;         ///< may be given up for another way
  };
  Conduct conduct;

  /// f += what a linear solve at u has on its right-hand side beside the residual. Collective.
  void add_gaps(Vec u, Vec f);
  bool closes_gaps() const;

  Mailbox& mailbox() { return mailbox_; }

private:
  void after_step(SNESLineSearch, Vec x, Vec y, Vec w, PetscBool* changed_y, PetscBool* changed_w);
  void before_linear_solve(KSP, Vec rhs, Vec du);
  void after_linear_solve(KSP, Vec rhs, Vec du);
  void test(SNES snes, PetscInt it, PetscReal x, PetscReal step, PetscReal norm, SNESConvergedReason* reason);
  bool gaps_settle(Vec u);
  bool gives_up(PetscReal norm);

  MotionProblem& motion_;
  LooseBodies& loose_;
  TangentReuse& reuse_;
  Mailbox& mailbox_;
  Handle<Vec> bare_residual_; // the right-hand side before gaps were added
  NewtonWatch watch_;
  double open_ = 0; // largest gap that the last iterate near the solution left, over a facet
  int near_ = 0;    // iterates whose residual was beside its tolerance
};

/// The name of a SNES's line search; empty without.
std::string line_search_of(SNES snes);

} // namespace impact
