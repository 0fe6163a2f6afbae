#pragma once
#include <impact/problem/discretisation.hpp>

/// When a residual of the motion counts as balanced (theory.md, when a step has converged). The nodes fall in
/// parts: bodies, divided by the stiffest material that meets at a node. The norm of the residual on each
/// part must fall below the largest of
///   atol;
///   rtol times the largest norm that it had in the solve, or the whole residual at its start if less;
///   once an iteration leaves more than half of it, its rounding error: 1e-15 of (u + largest cell) times the
///   cells' part of the tangent's diagonal, and 4e-15 (5e-16 of weights that close gaps) of (u + coordinate)
///   times the rest of it, contact's and rigid bodies'; a fiftieth of all that where other constraints press
///   than in the iterate before.
/// So neither the stiffness nor the load nor the rounding of one part excuses forces left on another.
namespace impact {

/// How far a solve goes: until the forces balance; until an iteration leaves a hundredth of the residual, so
/// that hardly a point is about to close or open any more; until a thousandth, or a tenth, is left of what it
/// began with.
enum class Aim { balance, settled, thousandth, tenth };

// Members beyond twelve: lengths of the problem, and for each part its sum, its rounding error, its history.
class ForceBalance {
public:
  /// Collective.
  explicit ForceBalance(const Discretisation& discretisation);

  /// The rounding error is that of another problem: what the last tangent said counts no more.
  void forget();
  /// A solve begins: what counts is relative to the residuals that follow.
  void start();
  void aim(Aim aim) { aim_ = aim; }
  /// The residual that comes is that of another set of constraints than the one before, or of the same.
  void note_set(bool other) { other_set_ = other; }
  /// Diagonals of the tangent at u: of the cells alone, and of all, in which contact `weighs_gaps` or has its
  /// penalties. Collective.
  void note_tangent(Vec u, Vec cells, Vec all, bool weighs_gaps);
  /// Holds the residual f against its tolerances. One reduction, nothing allocated. Collective.
  void judge(Vec f, double atol, double rtol);
  /// Answers for `snes`, whose function and tolerances these are, like SNESConvergedDefault, but never for
  /// the length of a step. Collective.
  SNESConvergedReason test(SNES snes, PetscInt iteration, PetscReal norm);

  /// What the last `judge` said: largest quotient of residual and tolerance of a part.
  double ratio() const { return ratio_; }
  bool holds() const { return ratio_ <= 1; }
  /// max(atol, rtol times the whole residual at the start).
  double force() const { return force_; }

private:
  int dim_, parts_ = 0;
  double largest_cell_ = 0, extent_ = 0;
  MPI_Comm comm_;
  std::vector<int> part_of_node_;       // of owned nodes, in the order of the vectors
  std::vector<double> sums_, rounding_; // squares of each part: of the residual and of its rounding
  std::vector<double> largest_, last_;  // residuals of each part in this solve
  std::vector<double> least_rounding_;  // of each part by the tangents of this solve
  Aim aim_ = Aim::balance;
  bool other_set_ = false;
  double first_ = -1, force_ = 0, ratio_ = 0; // first_ < 0: no residual yet
};

} // namespace impact
