#pragma once
#include "row_messages.hpp"
#include <cstdint>
#include <impact/mesh/field_layout.hpp>
#include <impact/petsc/handle.hpp>
#include <optional>

/// What SparseAssembly does with MatrixFormat::sbaij: the blocks of node pairs on and above the diagonal
/// alone, each stored once, column by column, and added at a precomputed place.
namespace impact {

class SymmetricBlocks {
public:
  /// `graph` and `groups` must outlive this. Collective.
  SymmetricBlocks(const FieldLayout& layout, const NodeGraph& graph, const std::vector<CellGroup>& groups);

  Mat matrix() const { return matrix_; }
  void zero();
  /// Reads the blocks [a][b] with a <= b of K, as cells number their nodes.
  void add(int group, int batch, const Batch* K);
  void finish();
  void set_diagonal(const std::vector<int>& dofs, double value);

private:
  void count_rows();
  void create_matrix(const FieldLayout& layout);
  void find_places();
  std::uint32_t place_of_own(int row, int slot) const;
  std::uint32_t place_of_ghost(int row, int slot) const;
  double* at_place(std::uint32_t block);
  void store_foreign_rows();
  void open();
  void close();
  template <int c> void add_cells(int group, int batch, const Batch* K);

  const NodeGraph& graph_;
  const std::vector<CellGroup>& groups_;
  int components_;
  Handle<Mat> matrix_;
  Mat own_block_ = nullptr;   // borrowed: the rank's own columns
  double* own_ = nullptr;     // its values between open and close
  std::vector<int> diagonal_; // [row] slot of the diagonal
  // First block of each own row among the own columns, of its foreign columns, of each ghost row. The blocks
  // of the second and third kind follow each other in outside_.
  std::vector<std::size_t> own_base_, foreign_base_, ghost_base_;
  std::vector<int> first_foreign_;  // [row] slot of the first foreign column above the diagonal
  std::vector<int> ghost_diagonal_; // [ghost row] slot of the diagonal
  std::vector<double> outside_;
  // [group][batch][a][lane][b >= a]: twice the block, own ones before those outside; odd where it is that of
  // (b, a).
  std::vector<std::vector<std::uint32_t>> places_;
  std::vector<std::uint32_t> received_; // blocks, in the order of the messages
  std::optional<RowMessages> messages_;
};

} // namespace impact
