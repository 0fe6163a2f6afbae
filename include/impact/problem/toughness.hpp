#pragma once
#include <impact/problem/discretisation.hpp>
#include <vector>

/// A toughness that follows the rate of strain and the temperature (T1): row "toughness" of the state table,
/// for each cell, at all its points, the factor on G_c that the next step works with, and the energy that the
/// cracks have cost beyond psi_phi.
namespace impact {

/// Writes the trial half of "toughness" from the committed one over a step dt between local displacements
/// [node][dim]; phi, history and temperature are those of the table.
void follow_toughness(const Discretisation& d, StateTable& state, double dt, const std::vector<double>& u,
                      const std::vector<double>& u_n);
/// The same of bodies at rest, whose cracks have cost G_c.
void start_toughness(const Discretisation& d, StateTable& state);

} // namespace impact
