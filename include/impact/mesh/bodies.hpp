#pragma once
#include <impact/mesh/field_layout.hpp>
#include <vector>

/// Bodies: the sets of nodes that cells join, on any ranks.
namespace impact {

struct Bodies {
  std::vector<int> of_node; ///< [local node]
  int count = 0;            ///< over all ranks; a body's number is the same on all of them
};

/// The bodies of a mesh; their numbers depend on the partition. `layout`: any of this mesh. Collective: names
/// of the pieces of each rank are gathered, so it belongs to the set-up.
Bodies find_bodies(const Mesh& mesh, const FieldLayout& layout);

} // namespace impact
