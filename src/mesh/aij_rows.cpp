#include "matrix_rows.hpp"
#include <algorithm>
#include <impact/petsc/error.hpp>

namespace impact {

namespace {

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

/// All entries, in PETSc's value arrays: own rows are written there, foreign rows into the message.
class AijRows : public MatrixRows {
public:
  AijRows(const FieldLayout& layout, const NodeGraph& graph, const std::vector<CellGroup>& groups);
  void add(int group, int batch, const Batch* K) override;
  void set_diagonal(const std::vector<int>& dofs, double value) override;

private:
  // Where the first of a node's rows stands: slots below `own_slots` at `own`, the others at `rest` (null
  // where there are none); the next row follows after the stride.
  struct Rows {
    double *own, *rest;
    int own_slots, own_stride, rest_stride;
  };
  Rows rows_of(int node) {
    const int row = graph_.row_of_node()[at(node)];
    if (row < 0) { // a ghost row has one list only
      const int slots = static_cast<int>(graph_.ghost_columns(-1 - row).size());
      return {elsewhere_.data() + ghost_base_[at(-1 - row)], nullptr, slots, slots * components_, 0};
    }
    const int slots = graph_.own_columns(row), more = foreign_columns_[at(row)];
    return {own_ + own_base_[at(row)], more > 0 ? foreign_ + foreign_base_[at(row)] : nullptr, slots,
            slots * components_, more * components_};
  }
  void lay_messages();
  void borrow() override;
  void give_back() override;
  template <int c> void add_cells(int group, int batch, const Batch* K);
  void add_received(const double* from) override;

  Mat foreign_block_ = nullptr;                   // borrowed from the matrix; null on one rank
  std::vector<PetscInt> own_base_, foreign_base_; // [row]
  std::vector<int> foreign_columns_;              // [row]
  double* foreign_ = nullptr;                     // the values of that block between open and close
  std::vector<std::size_t> ghost_base_;           // [ghost row] into elsewhere_
};

AijRows::AijRows(const FieldLayout& layout, const NodeGraph& graph, const std::vector<CellGroup>& groups)
    : MatrixRows(layout, graph, groups) {
  const int c = components_;
  std::vector<PetscInt> start{0}, column, merged;
  for (int r = 0; r < graph_.row_count(); ++r) {
    const auto list = graph_.columns(r);
    merged.resize(list.size());
    std::merge(list.begin(), list.begin() + graph_.own_columns(r), list.begin() + graph_.own_columns(r),
               list.end(), merged.begin());
    for (int k = 0; k < c; ++k) {
      for (const PetscInt node : merged)
        for (int j = 0; j < c; ++j) column.push_back(node * c + j);
      start.push_back(static_cast<PetscInt>(column.size()));
    }
  }
  create(MATAIJ);
  check(MatSeqAIJSetPreallocationCSR(matrix_, start.data(), column.data(), nullptr));
  check(MatMPIAIJSetPreallocationCSR(matrix_, start.data(), column.data(), nullptr));
  keep_pattern(layout);
  own_block_ = matrix_;
  if (is_parallel()) check(MatMPIAIJGetSeqAIJ(matrix_, &own_block_, &foreign_block_, nullptr));
  own_base_ = row_bases(own_block_, graph_.row_count(), c);
  if (foreign_block_) foreign_base_ = row_bases(foreign_block_, graph_.row_count(), c);
  for (int r = 0; r < graph_.row_count(); ++r)
    foreign_columns_.push_back(static_cast<int>(graph_.columns(r).size()) - graph_.own_columns(r));
  lay_messages();
}

void AijRows::lay_messages() {
  const std::size_t block = at(components_ * components_);
  ghost_base_.push_back(0);
  for (int g = 0; g < graph_.ghost_row_count(); ++g)
    ghost_base_.push_back(ghost_base_.back() + block * graph_.ghost_columns(g).size());
  elsewhere_.resize(ghost_base_.back());
  std::vector<std::size_t> received_base{0};
  for (int k = 0; k < static_cast<int>(graph_.received_rows().size()); ++k)
    received_base.push_back(received_base.back() + block * graph_.received_slots(k).size());
  messages_.emplace(graph_, matrix_, elsewhere_.data(), ghost_base_, received_base);
}

void AijRows::borrow() {
  check(MatSeqAIJGetArray(own_block_, &own_));
  if (foreign_block_) check(MatSeqAIJGetArray(foreign_block_, &foreign_));
}

void AijRows::give_back() {
  check(MatSeqAIJRestoreArray(own_block_, &own_));
  if (foreign_block_) check(MatSeqAIJRestoreArray(foreign_block_, &foreign_));
}

// A node's rows for all lanes before the next node's, so that its part of K stays in the nearest cache.
template <int c> void AijRows::add_cells(int group, int batch, const Batch* K) {
  const CellGroup& cells = groups_[at(group)];
  const int used = cells.lanes_in_use(batch), nodes = cells.shape->nodes;
  const int* node = batch_nodes(cells, batch);
  const std::uint16_t* slots =
      graph_.slots(group).data() + static_cast<std::ptrdiff_t>(batch) * lanes * nodes * nodes;
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

void AijRows::add(int group, int batch, const Batch* K) {
  open();
  with_components(components_, [&](auto c) { add_cells<c>(group, batch, K); });
}

void AijRows::add_received(const double* from) {
  const int c = components_;
  for (int k = 0; k < static_cast<int>(graph_.received_rows().size()); ++k) {
    const int row = graph_.received_rows()[at(k)], own_slots = graph_.own_columns(row);
    const auto slots = graph_.received_slots(k);
    for (int i = 0; i < c; ++i)
      for (const std::uint16_t slot : slots) {
        double* to = slot < own_slots ? own_ + own_base_[at(row)] + (i * own_slots + slot) * c
                                      : foreign_ + foreign_base_[at(row)] +
                                            (i * foreign_columns_[at(row)] + slot - own_slots) * c;
        for (int j = 0; j < c; ++j) to[j] += *from++;
      }
  }
}

void AijRows::set_diagonal(const std::vector<int>& dofs, double value) {
  open();
  for (const int dof : dofs) {
    const int row = graph_.row_of_node()[at(dof / components_)], k = dof % components_;
    const int own_slots = graph_.own_columns(row), slot = graph_.slot(row, graph_.first_node() + row);
    own_[own_base_[at(row)] + (k * own_slots + slot) * components_ + k] = value;
  }
  close();
}

} // namespace

std::unique_ptr<MatrixRows> make_aij_rows(const FieldLayout& layout, const NodeGraph& graph,
                                          const std::vector<CellGroup>& groups) {
  return std::make_unique<AijRows>(layout, graph, groups);
}

} // namespace impact
