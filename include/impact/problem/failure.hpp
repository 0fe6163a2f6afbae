#pragma once
#include <impact/problem/discretisation.hpp>
#include <vector>

/// Growth of the failure measure over a step (55d), pointwise after the motion: row "jc_failure" of the state
/// table.
namespace impact {

/// Local arrays; the rows "jc_failure" and "history" come from the table.
struct FailureStep {
  double dt = 0;
  const std::vector<double>* u = nullptr;     ///< accepted displacement at t_{n+1} [node][dim]
  const std::vector<double>* phi = nullptr;   ///< that the motion solve saw, or null [node]
  const std::vector<double>* theta = nullptr; ///< that the motion solve saw, or null [node]
};

/// Writes the trial half of "jc_failure" from the committed one. False when a value is not finite, on all
/// ranks. Collective.
bool grow_failure(const Discretisation& d, StateTable& state, const FailureStep& step);

} // namespace impact
