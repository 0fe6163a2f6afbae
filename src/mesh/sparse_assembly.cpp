#include "row_messages.hpp"
#include "symmetric_blocks.hpp"
#include <algorithm>
#include <impact/mesh/sparse_assembly.hpp>
#include <impact/petsc/error.hpp>
#include <optional>
#include <stdexcept>

namespace impact {

namespace {

std::size_t at(int k) { return static_cast<std::size_t>(k); }

// First value of each node's first row in an AIJ block.
std::vector<PetscInt> row_bases(Mat block, int rows, int components) {
  PetscInt count = 0;
  const PetscInt *start = nullptr, *column = nullptr;
  PetscBool done = PETSC_FALSE;
  check(MatGetRowIJ(block, 0, PETSC_FALSE, PETSC_FALSE, &count, &start, &column, &done));
  std::vector<PetscInt> base(at(rows));
  for (int r = 0; r < rows; ++r) base[at(r)] = start[r * components];
  check(MatRestoreRowIJ(block, 0, PETSC_FALSE, PETSC_FALSE, &count, &start, &column, &done));
  return base;
}

// Adds one lane's block of a node pair.
template <int c> void add_block(const double* from, int nodes, double* to, int stride) {
  for (int i = 0; i < c; ++i, from += nodes * c * lanes, to += stride)
    for (int j = 0; j < c; ++j) to[j] += from[j * lanes];
}

} // namespace

struct SparseAssembly::Impl {
  const NodeGraph& graph;
  const std::vector<CellGroup>& groups;
  int components;
  Mat own_block = nullptr,
      foreign_block = nullptr;                  // borrowed from the matrix; the second is null on one rank
  std::vector<PetscInt> own_base, foreign_base; // [row]
  std::vector<int> foreign_columns;             // [row]
  double *own = nullptr, *foreign = nullptr;    // the value arrays between open and close
  bool is_open = false;
  std::vector<std::size_t> ghost_base; // [ghost row] into `ghost`
  std::vector<double> ghost;           // the message
  std::optional<RowMessages> messages;

  Impl(const NodeGraph& g, const std::vector<CellGroup>& c, int k) : graph(g), groups(c), components(k) {}

  // Where the first of a node's rows stands: slots below `own_slots` at `own`, the others at `rest` (null
  // where there are none); the next row follows after the stride.
  struct Rows {
    double *own, *rest;
    int own_slots, own_stride, rest_stride;
  };
  Rows rows_of(int node) {
    const int row = graph.row_of_node()[at(node)];
    if (row < 0) { // a ghost row has one list only
      const int slots = static_cast<int>(graph.ghost_columns(-1 - row).size());
      return {ghost.data() + ghost_base[at(-1 - row)], nullptr, slots, slots * components, 0};
    }
    const int slots = graph.own_columns(row), more = foreign_columns[at(row)];
    return {own + own_base[at(row)], more > 0 ? foreign + foreign_base[at(row)] : nullptr, slots,
            slots * components, more * components};
  }

  void lay_messages(Mat matrix);
  void add(const std::vector<double>& received);
  template <int c> void add(int group, int batch, const Batch* K);
};

void SparseAssembly::Delete::operator()(Impl* impl) const { delete impl; }
void SparseAssembly::Delete::operator()(SymmetricBlocks* blocks) const { delete blocks; }

Mat SparseAssembly::matrix() const { return blocks_ ? blocks_->matrix() : matrix_.get(); }

SparseAssembly::SparseAssembly(const FieldLayout& layout, const Mesh& mesh,
                               const std::vector<CellGroup>& groups,
                               const std::vector<std::pair<PetscInt, PetscInt>>& extra, MatrixFormat format)
    : own_graph_(std::make_unique<NodeGraph>(mesh, groups, extra)) {
  if (format == MatrixFormat::sbaij) {
    blocks_.reset(new SymmetricBlocks(layout, *own_graph_, groups));
    return;
  }
  impl_.reset(new Impl(*own_graph_, groups, layout.components()));
  create_matrix(layout);
}

SparseAssembly::SparseAssembly(const FieldLayout& layout, const NodeGraph& graph,
                               const std::vector<CellGroup>& groups)
    : impl_(new Impl(graph, groups, layout.components())) {
  create_matrix(layout);
}

void SparseAssembly::create_matrix(const FieldLayout& layout) {
  Impl& s = *impl_;
  const NodeGraph& graph = s.graph;
  const int rows = graph.row_count(), c = s.components;
  if (c < 1 || c > 3) throw std::logic_error("SparseAssembly: 1 to 3 components per node");

  std::vector<PetscInt> start{0}, column, merged;
  for (int r = 0; r < rows; ++r) {
    const auto list = graph.columns(r);
    merged.resize(list.size());
    std::merge(list.begin(), list.begin() + graph.own_columns(r), list.begin() + graph.own_columns(r),
               list.end(), merged.begin());
    for (int k = 0; k < c; ++k) {
      for (const PetscInt node : merged)
        for (int j = 0; j < c; ++j) column.push_back(node * c + j);
      start.push_back(static_cast<PetscInt>(column.size()));
    }
  }
  ISLocalToGlobalMapping mapping = nullptr;
  check(MatCreate(graph.comm(), matrix_.out()));
  check(MatSetSizes(matrix_, rows * c, rows * c, PETSC_DETERMINE, PETSC_DETERMINE));
  check(MatSetBlockSize(matrix_, c));
  check(MatSetType(matrix_, MATAIJ));
  check(MatSeqAIJSetPreallocationCSR(matrix_, start.data(), column.data(), nullptr));
  check(MatMPIAIJSetPreallocationCSR(matrix_, start.data(), column.data(), nullptr));
  check(DMGetLocalToGlobalMapping(layout.dm(), &mapping));
  check(MatSetLocalToGlobalMapping(matrix_, mapping, mapping));
  // The positions hold for this pattern only.
  check(MatSetOption(matrix_, MAT_NEW_NONZERO_LOCATION_ERR, PETSC_TRUE));
  check(MatSetOption(matrix_, MAT_KEEP_NONZERO_PATTERN, PETSC_TRUE));

  PetscBool parallel = PETSC_FALSE;
  check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(matrix_.get()), MATMPIAIJ, &parallel));
  s.own_block = matrix_;
  if (parallel) check(MatMPIAIJGetSeqAIJ(matrix_, &s.own_block, &s.foreign_block, nullptr));
  s.own_base = row_bases(s.own_block, rows, c);
  if (parallel) s.foreign_base = row_bases(s.foreign_block, rows, c);
  for (int r = 0; r < rows; ++r)
    s.foreign_columns.push_back(static_cast<int>(graph.columns(r).size()) - graph.own_columns(r));
  s.lay_messages(matrix_);
}

void SparseAssembly::Impl::lay_messages(Mat matrix) {
  const std::size_t block = at(components * components);
  ghost_base.push_back(0);
  for (int g = 0; g < graph.ghost_row_count(); ++g)
    ghost_base.push_back(ghost_base.back() + block * graph.ghost_columns(g).size());
  ghost.resize(ghost_base.back());
  std::vector<std::size_t> received_base{0};
  for (int k = 0; k < static_cast<int>(graph.received_rows().size()); ++k)
    received_base.push_back(received_base.back() + block * graph.received_slots(k).size());
  messages.emplace(graph, matrix, ghost.data(), ghost_base, received_base);
}

void SparseAssembly::open() {
  Impl& s = *impl_;
  if (s.is_open) return;
  s.is_open = true;
  check(MatSeqAIJGetArray(s.own_block, &s.own));
  if (s.foreign_block) check(MatSeqAIJGetArray(s.foreign_block, &s.foreign));
}

// PETSc's assembly marks the matrix as changed, so that solvers see it; nothing of ours is left to be sent.
void SparseAssembly::close() {
  Impl& s = *impl_;
  if (!s.is_open) return;
  s.is_open = false;
  check(MatSeqAIJRestoreArray(s.own_block, &s.own));
  if (s.foreign_block) check(MatSeqAIJRestoreArray(s.foreign_block, &s.foreign));
  s.own = s.foreign = nullptr;
  check(MatSetOption(matrix_, MAT_NO_OFF_PROC_ENTRIES, PETSC_TRUE));
  check(MatAssemblyBegin(matrix_, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(matrix_, MAT_FINAL_ASSEMBLY));
  check(MatSetOption(matrix_, MAT_NO_OFF_PROC_ENTRIES, PETSC_FALSE));
}

void SparseAssembly::zero() {
  if (blocks_) return blocks_->zero();
  close();
  check(MatZeroEntries(matrix_));
  std::fill(impl_->ghost.begin(), impl_->ghost.end(), 0.0);
}

// A node's rows for all lanes before the next node's, so that its part of K stays in the nearest cache.
template <int c> void SparseAssembly::Impl::add(int group, int batch, const Batch* K) {
  const CellGroup& cells = groups[at(group)];
  const int used = cells.lanes_in_use(batch), nodes = cells.shape->nodes;
  const int* node = batch_nodes(cells, batch);
  const std::uint16_t* slots =
      graph.slots(group).data() + static_cast<std::ptrdiff_t>(batch) * lanes * nodes * nodes;
  const double* values = reinterpret_cast<const double*>(K);
  for (int a = 0; a < nodes; ++a, values += c * nodes * c * lanes)
    for (int l = 0; l < used; ++l) {
      const Rows to = rows_of(node[a * lanes + l]);
      const std::uint16_t* slot = slots + (l * nodes + a) * nodes;
      if (to.rest == nullptr)
        for (int b = 0; b < nodes; ++b)
          add_block<c>(values + b * c * lanes + l, nodes, to.own + slot[b] * c, to.own_stride);
      else
        for (int b = 0; b < nodes; ++b) {
          const int k = slot[b] - to.own_slots;
          const bool rest = k >= 0;
          add_block<c>(values + b * c * lanes + l, nodes, rest ? to.rest + k * c : to.own + slot[b] * c,
                       rest ? to.rest_stride : to.own_stride);
        }
    }
}

void SparseAssembly::add(int group, int batch, const Batch* K) {
  if (blocks_) return blocks_->add(group, batch, K);
  open();
  with_components(impl_->components, [&](auto c) { impl_->add<c>(group, batch, K); });
}

void SparseAssembly::Impl::add(const std::vector<double>& received) {
  const int c = components;
  const double* from = received.data();
  for (int k = 0; k < static_cast<int>(graph.received_rows().size()); ++k) {
    const int row = graph.received_rows()[at(k)], own_slots = graph.own_columns(row);
    const auto slots = graph.received_slots(k);
    for (int i = 0; i < c; ++i)
      for (const std::uint16_t slot : slots) {
        double* to = slot < own_slots ? own + own_base[at(row)] + (i * own_slots + slot) * c
                                      : foreign + foreign_base[at(row)] +
                                            (i * foreign_columns[at(row)] + slot - own_slots) * c;
        for (int j = 0; j < c; ++j) to[j] += *from++;
      }
  }
}

void SparseAssembly::finish() {
  if (blocks_) return blocks_->finish();
  Impl& s = *impl_;
  open();
  if (s.messages->any()) {
    s.add(s.messages->exchange());
    std::fill(s.ghost.begin(), s.ghost.end(), 0.0);
  }
  close();
}

void SparseAssembly::set_diagonal(const std::vector<int>& dofs, double value) {
  if (blocks_) return blocks_->set_diagonal(dofs, value);
  Impl& s = *impl_;
  open();
  for (const int dof : dofs) {
    const int row = s.graph.row_of_node()[at(dof / s.components)], k = dof % s.components;
    const int own_slots = s.graph.own_columns(row), slot = s.graph.slot(row, s.graph.first_node() + row);
    s.own[s.own_base[at(row)] + (k * own_slots + slot) * s.components + k] = value;
  }
  close();
}

} // namespace impact
