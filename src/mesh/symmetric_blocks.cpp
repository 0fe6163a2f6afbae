#include "matrix_formats.hpp"
#include <algorithm>
#include <experimental/simd>
#include <impact/petsc/error.hpp>
#include <limits>
#include <optional>
#include <stdexcept>

namespace impact {

namespace {

using Pair = std::experimental::fixed_size_simd<double, 2>;

Pair pair_at(const double* values) { return {values, std::experimental::element_aligned}; }

// y = A x for blocks on and above the diagonal, each stored by columns. The sums of a row stand apart for
// each column of a block, so that none waits for another.
template <int c>
void multiply(PetscInt rows, const PetscInt* start, const PetscInt* column, const double* value,
              const double* x, double* y) {
  const auto at = [](PetscInt node) { return static_cast<std::ptrdiff_t>(node) * c; };
  std::fill(y, y + at(rows), 0.0);
  for (PetscInt row = 0; row < rows; ++row) {
    double own[c], third[c] = {};
    Pair sum[c];
    for (int j = 0; j < c; ++j) own[j] = x[at(row) + j], sum[j] = 0;
    const auto add = [&](const double* other) {
      for (int j = 0; j < c; ++j) {
        sum[j] += pair_at(value + j * c) * other[j];
        if (c == 3) third[j] += value[j * c + 2] * other[j];
      }
    };
    PetscInt k = start[row];
    const PetscInt end = start[row + 1];
    if (k < end && column[k] == row) {
      add(own);
      value += c * c;
      ++k;
    }
    for (; k < end; ++k, value += c * c) {
      add(x + at(column[k]));
      double below[c] = {};
      for (int j = 0; j < c; ++j)
        for (int i = 0; i < c; ++i) below[j] += value[j * c + i] * own[i];
      for (int j = 0; j < c; ++j) y[at(column[k]) + j] += below[j];
    }
    for (int j = 0; j < c; ++j) {
      y[at(row)] += sum[j][0];
      y[at(row) + 1] += sum[j][1];
      if (c == 3) y[at(row) + 2] += third[j];
    }
  }
}

template <int c> PetscErrorCode mat_mult(Mat matrix, Vec x, Vec y) {
  Mailbox mailbox; // an exception has no way through PETSc
  return mailbox.guarded([&] {
    PetscInt rows = 0;
    const PetscInt *start = nullptr, *column = nullptr;
    PetscBool done = PETSC_FALSE;
    double* values = nullptr;
    const double* from = nullptr;
    double* to = nullptr;
    check(MatGetRowIJ(matrix, 0, PETSC_FALSE, PETSC_TRUE, &rows, &start, &column, &done));
    check(MatSeqSBAIJGetArray(matrix, &values));
    check(VecGetArrayRead(x, &from));
    check(VecGetArrayWrite(y, &to));
    multiply<c>(rows, start, column, values, from, to);
    check(PetscLogFlops(2.0 * c * c * (2.0 * start[rows] - rows)));
    check(VecRestoreArrayWrite(y, &to));
    check(VecRestoreArrayRead(x, &from));
    check(MatSeqSBAIJRestoreArray(matrix, &values));
    check(MatRestoreRowIJ(matrix, 0, PETSC_FALSE, PETSC_TRUE, &rows, &start, &column, &done));
  });
}

// Gives a SEQSBAIJ matrix with blocks of 2 or 3 a product of our own, which keeps the sums of a row in
// registers where PETSc 3.18 stores and loads them with each block (200,000 dofs: 12 ns per quadrilateral
// against 18, 73 per hexahedron against 102). Others keep PETSc's.
void use_own_product(Mat matrix) {
  PetscInt size = 0;
  check(MatGetBlockSize(matrix, &size));
  PetscErrorCode (*product)(Mat, Vec, Vec) = size == 2 ? mat_mult<2> : size == 3 ? mat_mult<3> : nullptr;
  if (product) check(MatSetOperation(matrix, MATOP_MULT, reinterpret_cast<void (*)()>(product)));
}

// Adds one lane's block of a node pair to a block stored by columns: that of (a, b), or that of (b, a).
// Gathered first, so that the compiler adds whole registers.
template <int c, bool transposed> void add_block(const double* from, int nodes, double* to) {
  double block[c * c];
  for (int i = 0; i < c; ++i)
    for (int j = 0; j < c; ++j) block[transposed ? i * c + j : j * c + i] = from[(i * nodes * c + j) * lanes];
  for (int k = 0; k < c * c; ++k) to[k] += block[k];
}

/// The blocks of node pairs on and above the diagonal alone, each stored once, column by column, and added at
/// a precomputed place. Of a cell matrix the blocks [a][b] with a <= b are read.
class SymmetricBlocks : public SparseAssembly {
public:
  SymmetricBlocks(const FieldLayout& layout, NodeGraph graph, const std::vector<CellGroup>& groups);
  void add(int group, int batch, const Batch* K) override;

private:
  void count_rows();
  void create_matrix(const FieldLayout& layout);
  void find_places();
  std::uint32_t place_of_own(int row, int slot) const;
  std::uint32_t place_of_ghost(int row, int slot) const;
  double* at_place(std::uint32_t block);
  void store_foreign_rows();
  void borrow() override;
  void give_back() override;
  void add_received(const double* from) override;
  double& diagonal(int row, int component) override;
  template <int c> void add_cells(int group, int batch, const Batch* K);

  std::vector<int> diagonal_; // [row] slot of the diagonal
  // First block of each own row among the own columns, and of its foreign columns. The blocks of the second
  // kind and those of ghost rows follow each other in elsewhere_.
  std::vector<std::size_t> own_base_{0}, foreign_base_{0};
  std::vector<int> first_foreign_;  // [row] slot of the first foreign column above the diagonal
  std::vector<int> ghost_diagonal_; // [ghost row] slot of the diagonal
  // [group][batch][a][lane][b >= a]: twice the block, own ones before those outside; odd where it is that of
  // (b, a).
  std::vector<std::vector<std::uint32_t>> places_;
  std::vector<std::uint32_t> received_; // blocks, in the order of the messages
};

SymmetricBlocks::SymmetricBlocks(const FieldLayout& layout, NodeGraph graph,
                                 const std::vector<CellGroup>& groups)
    : SparseAssembly(layout.components(), std::move(graph), groups) {
  count_rows();
  create_matrix(layout);
  find_places();
  received_start_.push_back(0);
  for (int k = 0; k < graph_.received_slots.count(); ++k) {
    const int row = graph_.received_row[at(k)];
    for (const std::uint16_t slot : graph_.received_slots[k])
      if (graph_.columns[row][slot] >= graph_.first_node + row) received_.push_back(place_of_own(row, slot));
    received_start_.push_back(received_.size());
  }
}

void SymmetricBlocks::count_rows() {
  for (int r = 0; r < graph_.columns.count(); ++r) {
    const auto columns = graph_.columns[r];
    const PetscInt node = graph_.first_node + r;
    const int own = graph_.own_columns[at(r)], all = static_cast<int>(columns.size());
    diagonal_.push_back(graph_.slot(r, node));
    first_foreign_.push_back(
        static_cast<int>(std::lower_bound(columns.begin() + own, columns.end(), node) - columns.begin()));
    own_base_.push_back(own_base_.back() + at(own - diagonal_.back()));
    foreign_base_.push_back(foreign_base_.back() + at(all - first_foreign_.back()));
  }
  ghost_start_.push_back(foreign_base_.back());
  for (int g = 0; g < graph_.ghost_columns.count(); ++g) {
    const auto columns = graph_.ghost_columns[g];
    const auto diagonal = std::lower_bound(columns.begin(), columns.end(), graph_.ghost_node[at(g)]);
    ghost_diagonal_.push_back(static_cast<int>(diagonal - columns.begin()));
    ghost_start_.push_back(ghost_start_.back() + at(columns.end() - diagonal));
  }
  const std::size_t outside = ghost_start_.back();
  if (own_base_.back() + outside > std::numeric_limits<std::uint32_t>::max() / 2)
    throw std::length_error("a symmetric matrix has too many blocks on a rank");
  elsewhere_.resize(outside * at(components_ * components_));
}

void SymmetricBlocks::create_matrix(const FieldLayout& layout) {
  std::vector<PetscInt> start{0}, column;
  for (int r = 0; r < graph_.columns.count(); ++r) {
    const auto list = graph_.columns[r];
    column.insert(column.end(), list.begin() + diagonal_[at(r)], list.begin() + graph_.own_columns[at(r)]);
    column.insert(column.end(), list.begin() + first_foreign_[at(r)], list.end());
    start.push_back(static_cast<PetscInt>(column.size()));
  }
  create(MATSBAIJ);
  check(MatSeqSBAIJSetPreallocationCSR(matrix_, components_, start.data(), column.data(), nullptr));
  check(MatMPISBAIJSetPreallocationCSR(matrix_, components_, start.data(), column.data(), nullptr));
  check(MatSetOption(matrix_, MAT_IGNORE_LOWER_TRIANGULAR, PETSC_TRUE));
  keep_pattern(layout);
  own_block_ = matrix_;
  if (is_parallel()) check(MatGetDiagonalBlock(matrix_, &own_block_));
  use_own_product(own_block_);
}

std::uint32_t SymmetricBlocks::place_of_own(int row, int slot) const {
  return static_cast<std::uint32_t>(slot < graph_.own_columns[at(row)]
                                        ? own_base_[at(row)] + at(slot - diagonal_[at(row)])
                                        : own_base_.back() + foreign_base_[at(row)] +
                                              at(slot - first_foreign_[at(row)]));
}

std::uint32_t SymmetricBlocks::place_of_ghost(int row, int slot) const {
  return static_cast<std::uint32_t>(own_base_.back() + ghost_start_[at(row)] +
                                    at(slot - ghost_diagonal_[at(row)]));
}

void SymmetricBlocks::find_places() {
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const CellGroup& group = groups_[g];
    const int nodes = node_count(group.shape);
    const auto& slots = graph_.slots[g];
    std::vector<std::uint32_t>& places = places_.emplace_back();
    places.reserve(at(group.cell_count) * at(nodes * (nodes + 1) / 2));
    for (int batch = 0; batch < group.batch_count; ++batch)
      for (int a = 0; a < nodes; ++a)
        for (int l = 0; l < group.lanes_in_use(batch); ++l) {
          const int* node = &group.node[at(batch) * at(nodes * lanes) + at(l)];
          const std::uint16_t* slot = &slots[at(batch * lanes + l) * at(nodes * nodes)];
          // The block of a pair if it is in the upper half; the other half is above the diagonal in the
          // other node's row.
          const auto upper = [](int slot_there, int first, std::uint32_t block) {
            return slot_there >= first ? std::optional(block) : std::nullopt;
          };
          const auto place = [&](int row_node, int column_node) {
            const int row = graph_.row_of_node[at(node[row_node * lanes])];
            const int s = slot[row_node * nodes + column_node];
            if (row < 0) return upper(s, ghost_diagonal_[at(-1 - row)], place_of_ghost(-1 - row, s));
            return upper(s, s < graph_.own_columns[at(row)] ? diagonal_[at(row)] : first_foreign_[at(row)],
                         place_of_own(row, s));
          };
          for (int b = a; b < nodes; ++b) {
            const auto block = place(a, b);
            places.push_back(block ? 2 * *block : 2 * *place(b, a) + 1);
          }
        }
    // The last batches look ahead too.
    places.resize(places.size() + at(lanes * nodes * (nodes + 1) / 2));
  }
}

double* SymmetricBlocks::at_place(std::uint32_t block) {
  const std::size_t size = at(components_ * components_), own = own_base_.back();
  return block < own ? own_ + block * size : elsewhere_.data() + (block - own) * size;
}

void SymmetricBlocks::borrow() { check(MatSeqSBAIJGetArray(own_block_, &own_)); }
void SymmetricBlocks::give_back() { check(MatSeqSBAIJRestoreArray(own_block_, &own_)); }

// A node's rows for all lanes before the next node's, so that its part of K stays in the nearest cache.
template <int c> void SymmetricBlocks::add_cells(int group, int batch, const Batch* K) {
  constexpr std::ptrdiff_t size = c * c;
  const int nodes = groups_[at(group)].shape->nodes, pairs = nodes * (nodes + 1) / 2;
  const int used = groups_[at(group)].lanes_in_use(batch);
  const std::uint32_t* place = places_[at(group)].data() + static_cast<std::ptrdiff_t>(batch) * pairs * lanes;
  const auto own_blocks = static_cast<std::uint32_t>(own_base_.back());
  double* const own = own_;
  double* const outside = elsewhere_.data();
  const double* values = reinterpret_cast<const double*>(K);
  const auto at_block = [&](std::uint32_t block) {
    return block < own_blocks ? own + block * size : outside + (block - own_blocks) * size;
  };
  for (int a = 0; a < nodes; ++a, values += c * nodes * c * lanes)
    for (int l = 0; l < used; ++l)
      for (int b = a; b < nodes; ++b, ++place) {
        const double* from = values + b * c * lanes + l;
        double* to = at_block(*place >> 1);
        // Rows of hexahedra are long and come from afar: a third off. In the plane it costs more than it
        // brings.
        if constexpr (c == 3) PETSC_Prefetch(at_block(place[pairs * lanes] >> 1), 1, PETSC_PREFETCH_HINT_T0);
        if (*place & 1)
          add_block<c, true>(from, nodes, to);
        else
          add_block<c, false>(from, nodes, to);
      }
}

void SymmetricBlocks::add(int group, int batch, const Batch* K) {
  open();
  with_components(components_, [&](auto c) { add_cells<c>(group, batch, K); });
}

// PETSc keeps the foreign columns to itself: their rows, few and on the rank's border, are handed over.
void SymmetricBlocks::store_foreign_rows() {
  const int c = components_;
  const double* from = elsewhere_.data();
  double block[9];
  for (int r = 0; r < graph_.columns.count(); ++r) {
    const PetscInt row = graph_.first_node + r;
    const auto columns = graph_.columns[r];
    for (std::size_t k = at(first_foreign_[at(r)]); k < columns.size(); ++k, from += c * c) {
      for (int i = 0; i < c; ++i)
        for (int j = 0; j < c; ++j) block[i * c + j] = from[j * c + i];
      check(MatSetValuesBlocked(matrix_, 1, &row, 1, &columns[k], block, INSERT_VALUES));
    }
  }
}

void SymmetricBlocks::add_received(const double* from) {
  const int size = components_ * components_;
  for (const std::uint32_t block : received_) {
    double* to = at_place(block);
    for (int i = 0; i < size; ++i) to[i] += *from++;
  }
  store_foreign_rows();
}

double& SymmetricBlocks::diagonal(int row, int k) {
  const int c = components_;
  return own_[own_base_[at(row)] * at(c * c) + at(k * c + k)];
}

} // namespace

std::unique_ptr<SparseAssembly> make_symmetric_blocks(const FieldLayout& layout, NodeGraph graph,
                                                      const std::vector<CellGroup>& groups) {
  return std::make_unique<SymmetricBlocks>(layout, std::move(graph), groups);
}

} // namespace impact
