#pragma once
#include <impact/mesh/cell_batches.hpp>
#include <impact/mesh/field_layout.hpp>
#include <impact/mesh/matrix_format.hpp>
#include <impact/mesh/node_graph.hpp>
#include <memory>
#include <utility>

/// A matrix over one nodal field and the precomputed positions at which cell matrices are added: own
/// rows straight into PETSc's value arrays, foreign rows packed and sent once per assembly to each neighbour
/// (no stash). One assembly: zero, add for every batch, finish. After finish others may
/// MatSetValues(ADD_VALUES) at the pairs of the pattern, foreign rows too (PETSc's stash), closed by
/// MatAssemblyBegin/End; a place outside the pattern is an error. With MatrixFormat::sbaij the matrix must be
/// symmetric: of all that is added, what stands below the diagonal is passed over.
namespace impact {

class MatrixRows;

class SparseAssembly {
public:
  /// Pattern: node pairs of every cell plus `extra` (pairs of GLOBAL nodes, any rank may give any pair; both
  /// (i,j) and (j,i) are inserted; always the diagonal). Collective.
  SparseAssembly(const FieldLayout& layout, const Mesh& mesh, const std::vector<CellGroup>& groups,
                 const std::vector<std::pair<PetscInt, PetscInt>>& extra = {},
                 MatrixFormat format = MatrixFormat::aij);
  /// Same in AIJ with a graph that several fields share; `graph` and `groups` must outlive the assembly.
  /// Collective.
  SparseAssembly(const FieldLayout& layout, const NodeGraph& graph, const std::vector<CellGroup>& groups);

  ~SparseAssembly();
  SparseAssembly(const SparseAssembly&) = delete;
  SparseAssembly& operator=(const SparseAssembly&) = delete;

  /// Block size set, all values zero and assembled after construction.
  Mat matrix() const;

  /// Sets all values to zero. Not collective.
  void zero();
  /// Adds K[node][comp][node][comp] of one batch; padding lanes are skipped. Not collective, no allocation.
  void add(int group, int batch, const Batch* K);
  /// Sends foreign rows to their owners and closes the assembly. The order of additions is fixed, so that
  /// equal input gives equal bits. Collective.
  void finish();
  /// Own rows' diagonal entries of the given owned local dofs (node * components + k) are set to `value`.
  /// After finish().
  void set_diagonal(const std::vector<int>& dofs, double value);

private:
  std::unique_ptr<const NodeGraph> own_graph_;
  std::unique_ptr<MatrixRows> rows_;
};

} // namespace impact
