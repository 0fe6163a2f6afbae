#pragma once
#include <impact/balance/energies.hpp>
#include <impact/problem/boundary_data.hpp>
#include <span>

/// What the advance of a crack sets free (theory.md, J1).
namespace impact {

/// Takes from what nodes are to advance by, `moved` as below, what would move a side of a body off itself: of
/// nodes that advance by a `part` (local [node]) between 0 and 1, that across the facets at them. Sides at
/// all of whose nodes `phi` (local [node], or empty) is above `broken` go along: there a crack has begun.
/// Collective.
void keep_sides(const Discretisation& d, const std::vector<double>& part, std::span<const double> phi,
                double broken, std::vector<double>& moved);

/// -dE/ds of the elastic energy E(X + s moved, u) by the reference places of the nodes, local [node][dim], at
/// fixed nodal displacements: with a `moved` that is 1 at the tip of a crack and 0 far away, its energy
/// release rate (J1), with the temperature and E of an expression as they are in their places (J2); committed
/// state, per unit thickness. Collective.
double find_release(const Discretisation& d, const BodyRows& rows, Vec u, const std::vector<double>& moved);
/// What inertia and body forces add to it (J2): int rho a . (Grad u moved), a the acceleration less the force
/// per mass, local [node][dim]. Collective.
double find_inertial_release(const Discretisation& d, Vec u, const std::vector<double>& a,
                             const std::vector<double>& moved);
/// What dead tractions and follower pressures on sides that advance add to it (J3), at time t: the change of
/// their work along u. Collective.
double find_load_release(const Discretisation& d, const BoundaryData& boundary, double t, Vec u,
                         const std::vector<double>& moved);

} // namespace impact
