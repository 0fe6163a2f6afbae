#pragma once
#include <impact/problem/discretisation.hpp>
#include <vector>

/// Growth of the fatigue variable over a step after the damage solve: row "fatigue" of the state table. That
/// of (F1') belongs to a point; that of (F2), by which the toughness falls, to a cell, at all its points.
namespace impact {

/// Local arrays; the rows "fatigue", "history" and "drive" come from the table.
struct FatigueStep {
  double dt = 0;
  const std::vector<double>* u = nullptr; ///< accepted displacement at t_{n+1} [node][dim]
  const std::vector<double>* u_n = nullptr;
  const std::vector<double>* phi = nullptr;   ///< at t_{n+1} [node]
  const std::vector<double>* theta = nullptr; ///< that the motion solve saw, or null [node]
  const std::vector<double>* theta_n = nullptr;
  const std::vector<double>* phi_n = nullptr;
  std::vector<double>* dissipation = nullptr; ///< added to: energy per volume at the points (F3); or null
};

/// What came of it.
struct FatigueGrowth {
  bool sound = true;              ///< on all ranks: every value is finite
  std::vector<double> dissipated; ///< energy of each material and per unit thickness, all ranks
  double least = 0;               ///< smallest of it per volume at a point, at most 0
};

/// Writes the trial half of "fatigue" from the committed one. Collective.
FatigueGrowth grow_fatigue(const Discretisation& d, StateTable& state, const FatigueStep& step);

} // namespace impact
