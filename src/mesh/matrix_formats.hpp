#pragma once
#include <impact/mesh/sparse_assembly.hpp>

namespace impact {

std::unique_ptr<SparseAssembly> make_aij_rows(const FieldLayout& layout, NodeGraph graph,
                                              const std::vector<CellGroup>& groups);
std::unique_ptr<SparseAssembly> make_symmetric_blocks(const FieldLayout& layout, NodeGraph graph,
                                                      const std::vector<CellGroup>& groups);

} // namespace impact
