#pragma once
#include <functional>
#include <impact/petsc/error.hpp>
#include <impact/petsc/preconditioner_reuse.hpp>
#include <impact/problem/motion.hpp>
#include <impact/solve/loose_bodies.hpp>
#include <petscts.h>
#include <utility>
#include <vector>

/// What Newton's method for displacements does beside its equations, in any SNES over them: multipliers of
/// the semismooth method and sliding follow every iterate before the residual is evaluated there, linear
/// solves close gaps, steps of rigid bodies go from their unknowns to their nodes and back to rotations, and
/// balance, gaps and a watch over cycles say when it ends (theory.md, 7).
namespace impact {

/// Tells from the norms of its residuals when Newton's method will not converge: where an active set does not
/// come to rest the iterates go round in circles, and steps taken in full that hardly change the residual
/// close nothing any more. What converges shows neither.
class NewtonWatch {
public:
  /// `full_steps`: no line search, whose short steps may change the residual little and lead on.
  void start(bool full_steps);
  /// To be told what part of a step of Newton's method a line search left.
  void note_step(double part);
  /// To be told the norm at every iterate, the first one included.
  void note(double norm);
  /// To be told before that how many constraints the step has left active.
  void note_set(int active) { set_ = active; }
  /// Iterates of the cycle in which the norms end, or 0: all norms of the last round are those of the round
  /// before to 4 %, of a cycle of two or three those of the last four iterates; the norms within it differ by
  /// more than a tenth; and as many constraints are active as in the round before, since norms alternate too
  /// while a set grows by a node at a time. A cycle of n iterates is seen after 2 n + 1 of them, or n + 5 if
  /// that is more.
  int cycle() const;
  /// Whether each of the last five full steps changed the norm by less than a tenth, or lowered it by less
  /// than a third where it is a thousandth of the first one already, and left as many constraints active.
  bool stalls() const { return full_steps_ && unchanged_ >= 5; }
  /// Whether each of the last three full steps raised the norm by more than half.
  bool leaves() const { return full_steps_ && risen_ >= 3; }
  /// Steps in a row that were cut to less than half, far from the solution.
  int cut_steps() const { return is_near() ? 0 : short_; }
  /// Whether the last norm is below a thousandth of the first one.
  bool is_near() const { return !norms_.empty() && is_near(norms_.back()); }

private:
  bool is_near(double norm) const { return !norms_.empty() && norm < 1e-3 * norms_.front(); }
  bool full_steps_ = false;
  int unchanged_ = 0; ///< steps in a row that did so
  int risen_ = 0;     ///< steps in a row that raised the norm
  int short_ = 0;     ///< steps in a row that were cut
  std::vector<double> norms_;
  std::vector<int> active_;
  int set_ = 0;
};

/// Modified Newton where factorisations cost more than iterations: a factorised tangent serves on while each
/// iteration with it still reduces the residual enough, over all passes of a step.
class TangentReuse {
public:
  /// `reduction`: largest quotient of two residual norms in a row at which the tangent serves on; 0: full
  /// Newton.
  explicit TangentReuse(double reduction) : reduction_(reduction) {}

  /// To be asked once in each iteration of `snes`, with what the tangent depends on beside the state. The
  /// same on all ranks.
  bool serves(SNES snes, PetscReal dt, PetscReal shift);
  double reduction() const { return reduction_; }
  /// The matrix holds something else, or nothing any more.
  void forget() { valid_ = false; }

private:
  double reduction_;
  bool valid_ = false;
  PetscReal dt_ = 0, shift_ = 0, norm_ = 0;
};

class NewtonHooks {
public:
  /// All must outlive the object; exceptions wait in the mailbox of `ts`.
  NewtonHooks(TS ts, MotionProblem& motion, LooseBodies& loose, TangentReuse& reuse);
  NewtonHooks(const NewtonHooks&) = delete;
  NewtonHooks& operator=(const NewtonHooks&) = delete;

  /// Hooks itself into `snes`, its line search and its KSP, which must outlive neither; all of them have read
  /// their options.
  void install(SNES snes);

  /// How the next solve goes.
  struct Conduct {
    Vec iterate = nullptr;        ///< the vector of the solve, about which linear solves close gaps
    bool goes_on = false;         ///< it goes on from a first iteration: its balance has a start already
    bool follows_sliding = false; ///< what slides to and fro sticks
    bool watched = false;         ///< may be given up for another way
    int patience = 0;             ///< given up once searches cut so many steps in a row; 0: not for that
    bool hurried = false;         ///< it was
    Aim aim = Aim::balance;
    bool alone = false;      ///< a linear solve outside of SNESSolve, without forcing term
    Handle<Vec> known;       ///< the answer of the linear solve that comes next, or empty
    bool indefinite = false; ///< the last linear solve found its matrix so
    /// Asked in each iteration of a linear solve, which ends unsolved where so many are too many.
    std::function<bool(PetscInt)> too_many;
  };
  Conduct conduct;
  PreconditionerReuse preconditioner{0};

  /// f += what a linear solve at u has on its right-hand side beside the residual. Collective.
  void add_gaps(Vec u, Vec f);
  bool closes_gaps() const;

  Mailbox& mailbox() { return mailbox_; }
  /// Linear iterations since the last call that PETSc does not count: of solves that were repeated.
  PetscInt take_repeated() { return std::exchange(linear_.in_vain, 0); }

  /// Iterations of a linear solve since the last call that were too many, or 0.
  PetscInt take_stopped() { return std::exchange(linear_.stopped, 0); }

private:
  void after_step(SNESLineSearch, Vec x, Vec y, Vec w, PetscBool* changed_y, PetscBool* changed_w);
  void before_linear_solve(KSP, Vec rhs, Vec du);
  void after_linear_solve(KSP, Vec rhs, Vec du);
  void count(KSP, PetscInt iterations, PetscReal norm);
  void repeat(KSP, Vec rhs, Vec du, bool indefinite);
  void test(SNES snes, PetscInt it, PetscReal x, PetscReal step, PetscReal norm, SNESConvergedReason* reason);
  bool gaps_settle(Vec u);
  bool gives_up();
  bool at_kink(SNESLineSearch search, Vec x, Vec y, Vec w) const;
  double part_of(Vec x, Vec y, Vec w) const;

  MotionProblem& motion_;
  LooseBodies& loose_;
  TangentReuse& reuse_;
  Mailbox& mailbox_;
  struct {
    SNES snes = nullptr;     // whose forcing terms count
    PetscReal rtol = 0;      // as the options say
    PetscInt most = 0;       // as well
    bool is_retried = false; // with a new preconditioner
    PetscInt in_vain = 0;    // iterations that such solves took before
    PetscInt stopped = 0;    // iterations of one that were too many
  } linear_;
  Handle<Vec> bare_residual_; // the right-hand side before gaps were added
  NewtonWatch watch_;
  double open_ = 0; // largest gap that the last iterate near the solution left, over a facet
  int near_ = 0;    // iterates whose residual was beside its tolerance
};

/// The name of a SNES's line search; empty without.
std::string line_search_of(SNES snes);

} // namespace impact
