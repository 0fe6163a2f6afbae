#pragma once
#include <array>
#include <cmath>
#include <impact/contact/contact_set.hpp>
#include <impact/problem/boundary_data.hpp>
#include <impact/problem/discretisation.hpp>
#include <impact/problem/rigid_bodies.hpp>
#include <string>
#include <vector>

/// What no solver can mend: bodies that stand in each other at the start, at any depth, and bodies that could
/// move rigidly: without inertia their stiffness matrix is singular, and a solver ends with
/// a pivot or with a nonsense displacement instead of a sentence.
namespace impact {

/// A set of cells connected by nodes that the prescribed displacements do not hold.
struct FreeBody {
  std::string regions;              ///< of its cells, separated by commas
  std::array<double, 3> centre{};   ///< mean of its nodes
  std::vector<std::string> motions; ///< "translation in x", "rotation about (0, 0)"
  bool touched = false;             ///< a contact sees something near it in the undeformed state
  int number = 0;                   ///< among find_bodies
  double size = 0;                  ///< largest distance of a node from the centre
};

/// Bodies with a rigid motion that vanishes at no prescribed dof, the same list on all ranks, by their lowest
/// global node. The motions are infinitesimal: 3 in the plane, 1 with a ring's symmetry (along the axis), 6
/// in space. Two cells that share one node count as one body: a hinge of that kind is not found. Collective.
std::vector<FreeBody> find_free_bodies(const Discretisation& discretisation, const BoundaryData& boundary,
                                       const ContactSet& contacts = {}, const RigidBodies& rigid = {});
/// "the body of region disc around (0, 10)".
std::string describe(const FreeBody& body, int dim);

/// What to say of nodes of deformable bodies on the axis of an axisymmetric run that nothing holds there,
/// empty for none: they would open a hole, or go through it. Collective.
std::string free_axis(const Discretisation& discretisation, const BoundaryData& boundary,
                      const RigidBodies& rigid);

/// For runs without inertia: a body that nothing holds throws UserError(data) that names it, its motions and
/// the remedy. One that a contact sees something near is held perhaps (LooseBodies): returns a sentence of
/// warning for each. Collective.
std::vector<std::string> require_held_bodies(const Discretisation& discretisation,
                                             const BoundaryData& boundary, const ContactSet& contacts,
                                             const RigidBodies& rigid = {});

/// Throws UserError(data) where a node of one side of a contact lies inside a cell of the other side's
/// bodies, unless the contact allows overlaps: what lies deeper than the pairs of the search reach has no
/// force. To be called after ContactInterface::initial_overlap, which names and mends what the pairs see. O(n
/// log n). Collective.
void refuse_deep_overlaps(const Discretisation& discretisation, const ContactSet& contacts);

} // namespace impact
