#pragma once
#include <impact/petsc/handle.hpp>
#include <vector>

/// Which points of a DMPlex are nodes: its vertices and, in a mesh of second order, its edges. That is where
/// its coordinates stand, so that a DM alone says what its nodes are.
namespace impact {

/// Nodes are numbered on each rank as PETSc's local vectors have them: in the order of the points, in which
/// the vertices come before the edges.
struct NodeMap {
  PetscInt first_vertex = 0, vertices = 0, first_edge = 0;
  PetscInt edges = 0; ///< 0 with first-order cells

  int count() const { return static_cast<int>(vertices + edges); }
  PetscInt point(int node) const {
    return node < vertices ? first_vertex + node : first_edge + (node - vertices);
  }
  /// -1: the point is no node.
  int node(PetscInt point) const {
    if (point >= first_vertex && point < first_vertex + vertices)
      return static_cast<int>(point - first_vertex);
    if (point >= first_edge && point < first_edge + edges)
      return static_cast<int>(vertices + (point - first_edge));
    return -1;
  }
};

/// Order of the cells of a DM, by its coordinates. Collective.
int order_of(DM dm);

/// Its nodes, for cells of that order.
NodeMap node_map(DM dm, int order);

/// Nodes of a point and of its closure, in the order of DMPlex.
std::vector<int> nodes_around(DM dm, const NodeMap& nodes, PetscInt point);

/// So many dofs on each node, and none elsewhere. Collective.
Handle<PetscSection> node_section(DM dm, int order, int dofs);

/// A mesh of first order becomes one of second order: nodes in the middle of its edges. Collective.
void add_edge_nodes(DM dm);

} // namespace impact
