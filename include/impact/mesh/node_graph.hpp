#pragma once
#include <cstdint>
#include <impact/mesh/cell_batches.hpp>
#include <span>
#include <utility>

/// Which nodes meet in a matrix row, and where in its row each node pair of a cell stands: everything about a
/// sparse matrix that does not depend on the number of components, so that fields share it.
namespace impact {

/// Node pairs of a rank. A row's columns stand in the order of PETSc's AIJ blocks: own columns by global
/// number, then foreign columns by global number; a slot is a position in that list. Rows of ghost nodes
/// (contributions of our cells to foreign rows) are sorted by owner, then global number, their columns by
/// global number.
class NodeGraph {
public:
  /// Pairs of every cell, the diagonal, and `extra` pairs of GLOBAL nodes in both directions (any rank may
  /// give any pair). Throws std::length_error when a row has more than 65535 columns. Collective.
  NodeGraph(const Mesh& mesh, const std::vector<CellGroup>& groups,
            const std::vector<std::pair<PetscInt, PetscInt>>& extra = {});

  struct Neighbour {
    int rank;
    int first_row, end_row; ///< send: range of ghost rows; receive: range of `received_row`
  };

  MPI_Comm comm() const { return comm_; }
  PetscInt first_node() const { return first_node_; }
  int row_count() const { return static_cast<int>(own_in_row_.size()); }
  std::span<const PetscInt> columns(int row) const { return list(row_start_, column_, row); }
  int own_columns(int row) const { return own_in_row_[static_cast<std::size_t>(row)]; }
  PetscInt ghost_node(int row) const { return ghost_node_[static_cast<std::size_t>(row)]; } ///< global
  int ghost_row_count() const { return static_cast<int>(ghost_start_.size()) - 1; }
  std::span<const PetscInt> ghost_columns(int row) const { return list(ghost_start_, ghost_column_, row); }
  /// Row of each local node: >= 0 an own row, else -1 - ghost row.
  std::span<const int> row_of_node() const { return row_of_node_; }
  /// [cell][node][node] slots of a cell group in its packed order, without padding.
  std::span<const std::uint16_t> slots(int group) const { return slots_[static_cast<std::size_t>(group)]; }

  std::span<const Neighbour> send() const { return send_; }
  std::span<const Neighbour> receive() const { return receive_; }
  std::span<const int> received_rows() const { return received_row_; } ///< own row of each received row
  std::span<const std::uint16_t> received_slots(int k) const {
    return {received_slot_.data() + received_start_[static_cast<std::size_t>(k)],
            received_slot_.data() + received_start_[static_cast<std::size_t>(k) + 1]};
  }
  /// Slot of a global node in an own row; it must be there.
  std::uint16_t slot(int row, PetscInt global_node) const;

private:
  using Start = std::vector<std::size_t>;
  static std::span<const PetscInt> list(const Start& start, const std::vector<PetscInt>& values, int row) {
    return {values.data() + start[static_cast<std::size_t>(row)],
            values.data() + start[static_cast<std::size_t>(row) + 1]};
  }
  struct Adjacency;
  int owner(PetscInt global_node) const;
  void lay_ghost_rows(const Mesh& mesh, const Adjacency& near);
  void lay_own_rows(const Mesh& mesh, const Adjacency& near, std::vector<std::pair<int, PetscInt>>& more);
  void find_slots(const Mesh& mesh, const std::vector<CellGroup>& groups, const Adjacency& near);

  MPI_Comm comm_;
  PetscInt first_node_ = 0;
  std::vector<PetscInt> rank_end_; // one past the last node of each rank
  Start row_start_, ghost_start_, received_start_;
  std::vector<PetscInt> column_, ghost_column_, ghost_node_;
  std::vector<int> own_in_row_, row_of_node_, received_row_;
  std::vector<std::vector<std::uint16_t>> slots_;
  std::vector<std::uint16_t> received_slot_;
  std::vector<Neighbour> send_, receive_;
};

} // namespace impact
