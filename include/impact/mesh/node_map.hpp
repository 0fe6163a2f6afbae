#pragma once
#include <impact/petsc/handle.hpp>
#include <vector>

/// Which points of a DMPlex are nodes: its vertices and, in a mesh of second order, its edges and, where its
/// cells have nodes there, its quadrilaterals and hexahedra. That is where its coordinates stand, so that a
/// DM alone says what its nodes are.
namespace impact {

/// Nodes are numbered on each rank as PETSc's local vectors have them: in the order of the points.
class NodeMap {
public:
  NodeMap() = default;
  /// `points`: of all nodes, rising.
  explicit NodeMap(std::vector<PetscInt> points);

  int count() const { return static_cast<int>(point_.size()); }
  PetscInt point(int node) const { return point_[static_cast<std::size_t>(node)]; }
  /// -1: the point is no node.
  int node(PetscInt point) const {
    const auto place = static_cast<std::size_t>(point - first_);
    return point >= first_ && place < node_.size() ? node_[place] : -1;
  }

private:
  std::vector<PetscInt> point_; // [node]
  PetscInt first_ = 0;
  std::vector<int> node_; // [point - first_]
};

/// Which points of second-order meshes are nodes beside the vertices: edges alone, or quadrilaterals and
/// hexahedra too.
enum class Middles { edges, all };

/// The nodes of a DM, by its coordinates.
NodeMap node_map(DM dm);

/// Order of the cells of a DM with these nodes. Collective.
int order_of(DM dm, const NodeMap& nodes);

/// Nodes of a point and of its closure, in the order of DMPlex.
std::vector<int> nodes_around(DM dm, const NodeMap& nodes, PetscInt point);

/// So many dofs on each node, and none elsewhere. Collective.
Handle<PetscSection> node_section(DM dm, const NodeMap& nodes, int dofs);

/// A mesh of first order becomes one of second order with straight edges: each new node has the mean place of
/// the vertices around it. Collective.
void add_middles(DM dm, Middles middles);

} // namespace impact
