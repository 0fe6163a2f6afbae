#pragma once
#include <impact/mesh/field_layout.hpp>
#include <vector>

/// Bodies: the sets of nodes that cells join, on any ranks.
namespace impact {

struct Bodies {
  std::vector<int> of_node; ///< [local node]; -1 where a node does not count
  int count = 0;            ///< over all ranks; a body's number is the same on all of them
};

/// The bodies of a mesh, or of its nodes that count ([local node], alike on the ranks that share one); their
/// numbers depend on the partition. `layout`: any of this mesh. Collective: names of the pieces of each rank
/// are gathered.
Bodies find_bodies(const Mesh& mesh, const FieldLayout& layout, const std::vector<char>& counts = {});

} // namespace impact
