#pragma once
#include <impact/solve/motion_solver.hpp>
#include <impact/time/pass_shell.hpp>
#include <string>

/// Uzawa's method around the motion: SNES shell `uzawa_`, whose pass solves the motion at the multipliers of
/// the contacts and then changes these, lambda <- <lambda - eps g>, until gaps and pressures are within the
/// tolerances of each contact (P. Alart, A. Curnier, Comput. Meth. Appl. Mech. Engng 92 (1991) 353;
/// theory.md, 8). Contacts by penalty or by the semismooth method take part with a first pass that is their
/// last.
namespace impact {

class Augmentation {
public:
  /// `solver` and `motion` must outlive the object. Collective.
  Augmentation(TS ts, MotionProblem& motion, MotionSolver& solver);
  Augmentation(const Augmentation&) = delete;
  Augmentation& operator=(const Augmentation&) = delete;

  void begin_attempt();
  /// Balances the motion from u as far as `aim` says. Collective.
  SNESConvergedReason solve(Vec u, Aim aim);

  PetscInt passes() const { return passes_; }             ///< of the attempt
  const std::string& failure() const { return failure_; } ///< why the last solve failed
  /// Contact force on the bodies that the last converged pass balanced, and what it left of the balance.
  Vec contact_force() const { return contact_force_; }
  Vec left() const { return left_; }

private:
  PassResult pass(PetscInt number, Vec u);
  SNESConvergedReason solve_pass(PetscInt number, Vec u);
  void meet(Vec u);
  void explain(SNESConvergedReason reason);

  MotionProblem& motion_;
  MotionSolver& solver_;
  PassShell shell_;
  Handle<SNES> snes_;
  Handle<Vec> contact_force_, left_;
  Aim aim_ = Aim::balance;
  PetscInt passes_ = 0;
  bool first_touch_ = false; // bodies that pressed nothing are being brought together
  bool rough_ = false;       // the next pass is solved to a rough tolerance
  std::string failure_;
};

} // namespace impact
