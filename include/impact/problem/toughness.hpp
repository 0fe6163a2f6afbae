#pragma once
#include <impact/problem/discretisation.hpp>
#include <vector>

/// A toughness that follows the rate of strain and the temperature (T1): row "toughness" of the state table,
/// for each cell, at all its points, the factor on G_c that the next step works with, and the energy that the
/// cracks have cost beyond psi_phi.
namespace impact {

/// Local arrays; the rows "toughness", "history" and, with heat, "theta" come from the table. Without u:
/// bodies at rest, whose cracks cost G_c.
struct ToughnessStep {
  double dt = 0;
  const std::vector<double>* u = nullptr; ///< accepted displacement at t_{n+1} [node][dim]
  const std::vector<double>* u_n = nullptr;
  const std::vector<double>* phi = nullptr; ///< at t_{n+1} [node]
  const std::vector<double>* phi_n = nullptr;
};

/// Writes the trial half of "toughness" from the committed one.
void follow_toughness(const Discretisation& d, StateTable& state, const ToughnessStep& step);

} // namespace impact
