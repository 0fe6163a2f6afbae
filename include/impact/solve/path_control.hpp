#pragma once
#include <impact/mesh/state_table.hpp>
#include <impact/problem/damage.hpp>
#include <impact/problem/motion.hpp>
#include <impact/time/types.hpp>

/// Static steps that follow a crack (theory.md, 10, (P1)-(P3)): the conditions are written over a load
/// parameter s that each step finds, so that cracks take up an asked energy in it. The time of the TS counts
/// the path.
namespace impact {

/// The row of a run that follows a path: the load and its growth over that of the path.
inline constexpr const char* load_parameter_row = "load_parameter";

/// The conditions of the step are those at another load of its end. Collective.
void go_to_load(MotionProblem& motion, double load);

class PathControl {
public:
  /// Adds the row of the load parameter s. Of `settings`, which must outlive the object, the energy that
  /// cracks take up at most in a step of the length dt.
  PathControl(StateTable& state, const CouplingScenario& settings);

  /// s at the start of the step, and where the motion of a try of the length `dt` begins.
  double start() const { return row_.committed[0]; }
  double guess(double dt) const;
  /// s of the next motion solve.
  double load() const { return load_; }
  /// A try of a step begins.
  void begin(double dt);

  /// How the conditions at the load of the motion go with it, as s^p: displacements by a factor f are those
  /// of s f^(1/p). Collective.
  void find_power(MotionProblem& motion, Vec u);
  /// Solves for phi as DamageProblem::solve does, of the step's displacement at the load of the motion scaled
  /// to the load that comes next, and finds that one: cracks take up the asked energy, unless the largest
  /// load of the step gives them less. Collective.
  ScalarOutcome solve(DamageProblem& damage, DamageStep step, std::vector<double>& phi);
  /// By what part of itself the last solve changed the load.
  double change() const { return change_; }

private:
  struct Bracket;
  double asked() const;

  const CouplingScenario& settings_;
  StateRow& row_;
  double dt_ = 0;     // of the try
  double load_ = 0;   // that the motion sees
  double change_ = 0; // |s/load - 1|
  double slope_ = 2;  // d ln D/d ln s, as the last search met it
  double power_ = 1;  // d ln u/d ln s
};

} // namespace impact
