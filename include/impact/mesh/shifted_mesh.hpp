#pragma once
#include <impact/mesh/mesh.hpp>
#include <vector>

namespace impact {

/// The same mesh on the same ranks with other reference coordinates; `shift`: [local node][dim], equal on all
/// ranks that share a node. The coordinates of the mesh's DM change with it, so that the old mesh is of no
/// more use. Throws UserError(data) where a cell is turned inside out. Collective.
Mesh shifted_mesh(const Mesh& mesh, const std::vector<double>& shift);

} // namespace impact
