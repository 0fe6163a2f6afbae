#pragma once
#include <impact/contact/contact_set.hpp>
#include <impact/problem/discretisation.hpp>

/// Bodies of a mesh that stand in each other at the start, at any depth.
namespace impact {

/// Throws UserError(data) where a node of one side of a contact lies inside a cell of the other side's
/// bodies, unless the contact allows overlaps: what lies deeper than the pairs of the search reach has no
/// force. To be called after ContactInterface::initial_overlap, which names and mends what the pairs see. O(n
/// log n). Collective.
void refuse_deep_overlaps(const Discretisation& discretisation, const ContactSet& contacts);

} // namespace impact
