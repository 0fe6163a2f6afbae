#pragma once
#include <impact/mesh/state_table.hpp>
#include <impact/solve/newton_hooks.hpp>
#include <impact/solve/path_control.hpp>
#include <string>

/// Static steps that follow a structure (theory.md, 10, (P4), (P5)): the conditions are written over a load
/// parameter s that Newton's method finds beside u, so that bodies move by a given length along the way of
/// the step before. The time of the TS counts the path.
namespace impact {

class ArcLength {
public:
  /// Adds the row of the load parameter. Of `settings`, which must outlive the object as the others must, the
  /// way of a step of the length dt. Collective.
  ArcLength(MotionProblem& motion, NewtonHooks& hooks, StateTable& state, const CouplingScenario& settings);

  /// Hooks itself into the line search of `snes`. Throws UserError(usage) for one that takes no full steps.
  void install(SNES snes);
  /// s at the start of the step.
  double start() const { return row_.committed[0]; }
  /// Whether s falls at the end of the last step.
  bool falls() const { return row_.committed[1] < 0; }
  /// Brings u and s to where the solve of a step begins, u before the first step being that of its start.
  /// False where bodies have not moved yet: `set_out` gives them a direction.
  bool predict(Vec u);
  /// The same along the answer to the load that begins, with `residual` at u and the operators of `snes`
  /// there. False without an answer. Throws UserError(usage) where no condition moves or loads anything.
  /// Collective.
  bool set_out(SNES snes, Vec u, Vec residual);
  /// Keeps the s that a solve which ended at u found; false where it is not as far along the path as asked.
  bool settle(Vec u);
  /// Why it is not, where the load has no say; else empty.
  std::string trouble() const;

  Mailbox& mailbox() { return hooks_.mailbox(); }

private:
  void border(SNESLineSearch search, Vec x, Vec y, PetscBool* changed);
  bool answer(SNES snes, Vec u, Vec residual, Vec p);
  void go_ahead(Vec u, double growth);
  double length() const;

  MotionProblem& motion_;
  NewtonHooks& hooks_;
  const CouplingScenario& settings_;
  StateRow& row_; // s and its growth over that of the path
  const StateRow& rate_;
  Handle<Vec> direction_, start_; // of the step, the largest component 1; where it begins
  double far_ = 0;                // where it ends: direction . (u - start)
  bool idle_ = false;             // conditions do not change with the load
};

} // namespace impact
