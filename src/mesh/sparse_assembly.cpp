#include "matrix_formats.hpp"
#include <algorithm>
#include <impact/petsc/error.hpp>
#include <stdexcept>

namespace impact {

SparseAssembly::SparseAssembly(int components, NodeGraph graph, const std::vector<CellGroup>& groups)
    : graph_(std::move(graph)), groups_(groups), components_(components) {
  if (components_ < 1 || components_ > 3)
    throw std::logic_error("SparseAssembly: 1 to 3 components per node");
}

void SparseAssembly::create(MatType type) {
  const int rows = graph_.columns.count() * components_;
  check(MatCreate(graph_.comm, matrix_.out()));
  check(PetscObjectGetNewTag(reinterpret_cast<PetscObject>(matrix_.get()), &tag_));
  check(MatSetSizes(matrix_, rows, rows, PETSC_DETERMINE, PETSC_DETERMINE));
  check(MatSetBlockSize(matrix_, components_));
  check(MatSetType(matrix_, type));
}

void SparseAssembly::keep_pattern(const FieldLayout& layout) {
  ISLocalToGlobalMapping mapping = nullptr;
  check(DMGetLocalToGlobalMapping(layout.dm(), &mapping));
  check(MatSetLocalToGlobalMapping(matrix_, mapping, mapping));
  check(MatSetOption(matrix_, MAT_NEW_NONZERO_LOCATION_ERR, PETSC_TRUE));
  check(MatSetOption(matrix_, MAT_KEEP_NONZERO_PATTERN, PETSC_TRUE));
}

// PETSc's assembly marks the matrix as changed, so that solvers see it; nothing of ours is left to be sent.
void SparseAssembly::close() {
  if (!std::exchange(is_open_, false)) return;
  give_back();
  check(MatSetOption(matrix_, MAT_NO_OFF_PROC_ENTRIES, PETSC_TRUE));
  check(MatAssemblyBegin(matrix_, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(matrix_, MAT_FINAL_ASSEMBLY));
  check(MatSetOption(matrix_, MAT_NO_OFF_PROC_ENTRIES, PETSC_FALSE));
}

void SparseAssembly::open() {
  if (!std::exchange(is_open_, true)) borrow();
}

void SparseAssembly::zero() {
  close();
  check(MatZeroEntries(matrix_));
  std::fill(elsewhere_.begin(), elsewhere_.end(), 0.0);
}

void SparseAssembly::finish() {
  open();
  if (!graph_.send.empty() || !graph_.receive.empty()) exchange();
  close();
}

bool SparseAssembly::is_parallel() const {
  int ranks = 1;
  MPI_Comm_size(graph_.comm, &ranks);
  return ranks > 1;
}

// The rows for one neighbour stand side by side, so that they are the message.
void SparseAssembly::exchange() {
  const std::size_t block = at(components_ * components_);
  const MPI_Comm comm = PetscObjectComm(reinterpret_cast<PetscObject>(matrix_.get()));
  std::vector<double> received(block * received_start_.back());
  std::vector<MPI_Request> requests;
  const auto post = [&](auto start, const NodeGraph::Neighbour& with, const std::vector<std::size_t>& row,
                        double* values) {
    const std::size_t first = row[at(with.first_row)], count = row[at(with.end_row)] - first;
    start(values + block * first, static_cast<int>(block * count), MPI_DOUBLE, with.rank, tag_, comm,
          &requests.emplace_back());
  };
  for (const auto& from : graph_.receive) post(MPI_Irecv, from, received_start_, received.data());
  for (const auto& to : graph_.send) post(MPI_Isend, to, ghost_start_, elsewhere_.data());
  MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
  add_received(received.data());
  std::fill(elsewhere_.begin(), elsewhere_.end(), 0.0);
}

void SparseAssembly::set_diagonal(const std::vector<int>& dofs, double value) {
  open();
  for (const int dof : dofs) diagonal(graph_.row_of_node[at(dof / components_)], dof % components_) = value;
  close();
}

std::unique_ptr<SparseAssembly> make_assembly(const FieldLayout& layout, const Mesh& mesh,
                                              const std::vector<CellGroup>& groups,
                                              const std::vector<std::pair<PetscInt, PetscInt>>& extra,
                                              MatrixFormat format) {
  return (format == MatrixFormat::sbaij ? make_symmetric_blocks
                                        : make_aij_rows)(layout, NodeGraph(mesh, groups, extra), groups);
}

} // namespace impact
