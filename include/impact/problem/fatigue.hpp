#pragma once
#include <impact/problem/discretisation.hpp>
#include <vector>

/// Growth of the fatigue variable over a step (F1'), pointwise after the damage solve: row "fatigue" of the
/// state table.
namespace impact {

/// Local arrays; the rows "fatigue" and "history" come from the table.
struct FatigueStep {
  double dt = 0;
  const std::vector<double>* u = nullptr; ///< accepted displacement at t_{n+1} [node][dim]
  const std::vector<double>* u_n = nullptr;
  const std::vector<double>* phi = nullptr;   ///< at t_{n+1} [node]
  const std::vector<double>* theta = nullptr; ///< that the motion solve saw, or null [node]
  const std::vector<double>* theta_n = nullptr;
};

class FatigueUpdate {
public:
  /// Needs the row "fatigue" (declare_state).
  FatigueUpdate(const Discretisation& discretisation, StateTable& state);

  /// Writes the trial half of "fatigue" from the committed one. False on all ranks when a value is not finite
  /// anywhere. Collective.
  bool advance(const FatigueStep& step);

  /// Energy that the growth of the last advance dissipates, of each material and per unit thickness, all
  /// ranks.
  const std::vector<double>& dissipated() const { return dissipated_; }
  /// Smallest of it per volume at a point, at most 0.
  double least_dissipation() const { return least_; }

private:
  const Discretisation& d_;
  StateRow &fatigue_, &history_;
  std::vector<double> dissipated_;
  double least_ = 0;
};

} // namespace impact
