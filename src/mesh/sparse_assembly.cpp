#include "matrix_rows.hpp"
#include <algorithm>
#include <impact/mesh/sparse_assembly.hpp>
#include <impact/petsc/error.hpp>
#include <stdexcept>

namespace impact {

MatrixRows::MatrixRows(const FieldLayout& layout, const NodeGraph& graph,
                       const std::vector<CellGroup>& groups)
    : graph_(graph), groups_(groups), components_(layout.components()) {
  if (components_ < 1 || components_ > 3)
    throw std::logic_error("SparseAssembly: 1 to 3 components per node");
}

void MatrixRows::create(MatType type) {
  const int rows = graph_.row_count() * components_;
  check(MatCreate(graph_.comm(), matrix_.out()));
  check(MatSetSizes(matrix_, rows, rows, PETSC_DETERMINE, PETSC_DETERMINE));
  check(MatSetBlockSize(matrix_, components_));
  check(MatSetType(matrix_, type));
}

void MatrixRows::keep_pattern(const FieldLayout& layout) {
  ISLocalToGlobalMapping mapping = nullptr;
  check(DMGetLocalToGlobalMapping(layout.dm(), &mapping));
  check(MatSetLocalToGlobalMapping(matrix_, mapping, mapping));
  check(MatSetOption(matrix_, MAT_NEW_NONZERO_LOCATION_ERR, PETSC_TRUE));
  check(MatSetOption(matrix_, MAT_KEEP_NONZERO_PATTERN, PETSC_TRUE));
}

// PETSc's assembly marks the matrix as changed, so that solvers see it; nothing of ours is left to be sent.
void MatrixRows::close() {
  if (!std::exchange(is_open_, false)) return;
  give_back();
  check(MatSetOption(matrix_, MAT_NO_OFF_PROC_ENTRIES, PETSC_TRUE));
  check(MatAssemblyBegin(matrix_, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(matrix_, MAT_FINAL_ASSEMBLY));
  check(MatSetOption(matrix_, MAT_NO_OFF_PROC_ENTRIES, PETSC_FALSE));
}

void MatrixRows::open() {
  if (!std::exchange(is_open_, true)) borrow();
}

void MatrixRows::zero() {
  close();
  check(MatZeroEntries(matrix_));
  std::fill(elsewhere_.begin(), elsewhere_.end(), 0.0);
}

void MatrixRows::finish() {
  open();
  if (messages_->any()) {
    add_received(messages_->exchange().data());
    std::fill(elsewhere_.begin(), elsewhere_.end(), 0.0);
  }
  close();
}

bool MatrixRows::is_parallel() const {
  int ranks = 1;
  MPI_Comm_size(graph_.comm(), &ranks);
  return ranks > 1;
}

SparseAssembly::SparseAssembly(const FieldLayout& layout, const Mesh& mesh,
                               const std::vector<CellGroup>& groups,
                               const std::vector<std::pair<PetscInt, PetscInt>>& extra, MatrixFormat format)
    : own_graph_(std::make_unique<NodeGraph>(mesh, groups, extra)),
      rows_(format == MatrixFormat::sbaij ? make_symmetric_blocks(layout, *own_graph_, groups)
                                          : make_aij_rows(layout, *own_graph_, groups)) {}

SparseAssembly::SparseAssembly(const FieldLayout& layout, const NodeGraph& graph,
                               const std::vector<CellGroup>& groups)
    : rows_(make_aij_rows(layout, graph, groups)) {}

SparseAssembly::~SparseAssembly() = default;

Mat SparseAssembly::matrix() const { return rows_->matrix(); }
void SparseAssembly::zero() { rows_->zero(); }
void SparseAssembly::add(int group, int batch, const Batch* K) { rows_->add(group, batch, K); }
void SparseAssembly::finish() { rows_->finish(); }
void SparseAssembly::set_diagonal(const std::vector<int>& dofs, double value) {
  rows_->set_diagonal(dofs, value);
}

} // namespace impact
