#include "matrix_rows.hpp"
#include "symmetric_product.hpp"
#include <algorithm>
#include <limits>
#include <stdexcept>

namespace impact {

namespace {

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
class SymmetricBlocks : public MatrixRows {
public:
  SymmetricBlocks(const FieldLayout& layout, const NodeGraph& graph, const std::vector<CellGroup>& groups);
  void add(int group, int batch, const Batch* K) override;
  void set_diagonal(const std::vector<int>& dofs, double value) override;

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
  template <int c> void add_cells(int group, int batch, const Batch* K);

  std::vector<int> diagonal_; // [row] slot of the diagonal
  // First block of each own row among the own columns, of its foreign columns, of each ghost row. The blocks
  // of the second and third kind follow each other in elsewhere_.
  std::vector<std::size_t> own_base_, foreign_base_, ghost_base_;
  std::vector<int> first_foreign_;  // [row] slot of the first foreign column above the diagonal
  std::vector<int> ghost_diagonal_; // [ghost row] slot of the diagonal
  // [group][batch][a][lane][b >= a]: twice the block, own ones before those outside; odd where it is that of
  // (b, a).
  std::vector<std::vector<std::uint32_t>> places_;
  std::vector<std::uint32_t> received_; // blocks, in the order of the messages
};

SymmetricBlocks::SymmetricBlocks(const FieldLayout& layout, const NodeGraph& graph,
                                 const std::vector<CellGroup>& groups)
    : MatrixRows(layout, graph, groups) {
  count_rows();
  create_matrix(layout);
  find_places();
  std::vector<std::size_t> ghost, received{0};
  const std::size_t size = at(components_ * components_);
  for (const std::size_t base : ghost_base_) ghost.push_back(size * base);
  for (int k = 0; k < static_cast<int>(graph_.received_rows().size()); ++k) {
    const int row = graph_.received_rows()[at(k)];
    const PetscInt node = graph_.first_node() + row;
    std::size_t count = 0;
    for (const std::uint16_t slot : graph_.received_slots(k))
      if (graph_.columns(row)[slot] >= node) {
        received_.push_back(place_of_own(row, slot));
        ++count;
      }
    received.push_back(received.back() + size * count);
  }
  messages_.emplace(graph_, matrix_, elsewhere_.data() + size * foreign_base_.back(), ghost, received);
}

void SymmetricBlocks::count_rows() {
  own_base_.push_back(0);
  foreign_base_.push_back(0);
  ghost_base_.push_back(0);
  for (int r = 0; r < graph_.row_count(); ++r) {
    const auto columns = graph_.columns(r);
    const PetscInt node = graph_.first_node() + r;
    const int own = graph_.own_columns(r), all = static_cast<int>(columns.size());
    diagonal_.push_back(graph_.slot(r, node));
    first_foreign_.push_back(
        static_cast<int>(std::lower_bound(columns.begin() + own, columns.end(), node) - columns.begin()));
    own_base_.push_back(own_base_.back() + at(own - diagonal_.back()));
    foreign_base_.push_back(foreign_base_.back() + at(all - first_foreign_.back()));
  }
  for (int g = 0; g < graph_.ghost_row_count(); ++g) {
    const auto columns = graph_.ghost_columns(g);
    const auto diagonal = std::lower_bound(columns.begin(), columns.end(), graph_.ghost_node(g));
    ghost_diagonal_.push_back(static_cast<int>(diagonal - columns.begin()));
    ghost_base_.push_back(ghost_base_.back() + static_cast<std::size_t>(columns.end() - diagonal));
  }
  const std::size_t outside = foreign_base_.back() + ghost_base_.back();
  if (own_base_.back() + outside > std::numeric_limits<std::uint32_t>::max() / 2)
    throw std::length_error("a symmetric matrix has too many blocks on a rank");
  elsewhere_.resize(outside * at(components_ * components_));
}

void SymmetricBlocks::create_matrix(const FieldLayout& layout) {
  std::vector<PetscInt> start{0}, column;
  for (int r = 0; r < graph_.row_count(); ++r) {
    const auto list = graph_.columns(r);
    column.insert(column.end(), list.begin() + diagonal_[at(r)], list.begin() + graph_.own_columns(r));
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
  return static_cast<std::uint32_t>(slot < graph_.own_columns(row)
                                        ? own_base_[at(row)] + at(slot - diagonal_[at(row)])
                                        : own_base_.back() + foreign_base_[at(row)] +
                                              at(slot - first_foreign_[at(row)]));
}

std::uint32_t SymmetricBlocks::place_of_ghost(int row, int slot) const {
  return static_cast<std::uint32_t>(own_base_.back() + foreign_base_.back() + ghost_base_[at(row)] +
                                    at(slot - ghost_diagonal_[at(row)]));
}

void SymmetricBlocks::find_places() {
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const CellGroup& group = groups_[g];
    const int nodes = node_count(group.shape);
    const auto slots = graph_.slots(static_cast<int>(g));
    std::vector<std::uint32_t>& places = places_.emplace_back();
    places.reserve(at(group.cell_count) * at(nodes * (nodes + 1) / 2));
    for (int batch = 0; batch < group.batch_count; ++batch)
      for (int a = 0; a < nodes; ++a)
        for (int l = 0; l < group.lanes_in_use(batch); ++l) {
          const int* node = &group.node[at(batch) * at(nodes * lanes) + at(l)];
          const std::uint16_t* slot = &slots[at(batch * lanes + l) * at(nodes * nodes)];
          // What is below the diagonal in one node's row is above it in the other's.
          const auto place = [&](int row_node, int column_node, bool& upper) {
            const int row = graph_.row_of_node()[at(node[row_node * lanes])];
            const int s = slot[row_node * nodes + column_node];
            if (row < 0) {
              const int diagonal = ghost_diagonal_[at(-1 - row)];
              upper = s >= diagonal;
              return upper ? place_of_ghost(-1 - row, s) : 0;
            }
            upper = s < graph_.own_columns(row) ? s >= diagonal_[at(row)] : s >= first_foreign_[at(row)];
            return upper ? place_of_own(row, s) : 0;
          };
          for (int b = a; b < nodes; ++b) {
            bool upper = false;
            std::uint32_t block = place(a, b, upper);
            if (upper) {
              places.push_back(2 * block);
              continue;
            }
            block = place(b, a, upper);
            places.push_back(2 * block + 1);
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
  for (int r = 0; r < graph_.row_count(); ++r) {
    const PetscInt row = graph_.first_node() + r;
    const auto columns = graph_.columns(r);
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

void SymmetricBlocks::set_diagonal(const std::vector<int>& dofs, double value) {
  const int c = components_;
  open();
  for (const int dof : dofs) {
    const int row = graph_.row_of_node()[at(dof / c)], k = dof % c;
    own_[own_base_[at(row)] * at(c * c) + at(k * c + k)] = value;
  }
  close();
}

} // namespace

std::unique_ptr<MatrixRows> make_symmetric_blocks(const FieldLayout& layout, const NodeGraph& graph,
                                                  const std::vector<CellGroup>& groups) {
  return std::make_unique<SymmetricBlocks>(layout, graph, groups);
}

} // namespace impact
