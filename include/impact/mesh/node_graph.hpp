#pragma once
#include <cstdint>
#include <impact/math/index.hpp>
#include <impact/mesh/cell_batches.hpp>
#include <span>
#include <utility>

/// Which nodes meet in a matrix row, and where in its row each node pair of a cell stands: everything about a
/// sparse matrix that does not depend on the number of components.
namespace impact {

/// Lists of different lengths, one behind the other.
template <class T> struct Lists {
  std::vector<std::size_t> start{0};
  std::vector<T> values;

  int count() const { return static_cast<int>(start.size()) - 1; }
  std::span<const T> operator[](int k) const {
    return {values.data() + start[at(k)], values.data() + start[at(k + 1)]};
  }
  void end_list() { start.push_back(values.size()); } ///< what was added since the last call
};

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

  /// A rank that gets rows, of the ghost rows, or that sends some, of the received ones.
  struct Neighbour {
    int rank;
    int first_row, end_row;
  };

  MPI_Comm comm;
  PetscInt first_node = 0;
  Lists<PetscInt> columns;          ///< [own row]
  std::vector<int> own_columns;     ///< [own row] how many of them come first
  std::vector<PetscInt> ghost_node; ///< [ghost row] its global node
  Lists<PetscInt> ghost_columns;
  std::vector<int> row_of_node; ///< [local node] >= 0 an own row, else -1 - ghost row
  /// [cell group][cell][node][node] slots in the group's packed order, without padding.
  std::vector<std::vector<std::uint16_t>> slots;
  std::vector<Neighbour> send, receive;
  std::vector<int> received_row; ///< own row of each received row
  Lists<std::uint16_t> received_slots;

  /// Slot of a global node in an own row; it must be there.
  std::uint16_t slot(int row, PetscInt global_node) const;

private:
  struct Adjacency;
  using Owner = std::function<int(PetscInt global_node)>;
  void lay_ghost_rows(const Mesh& mesh, const Adjacency& near, const Owner& owner);
  void lay_own_rows(const Mesh& mesh, const Adjacency& near, std::vector<std::pair<int, PetscInt>>& more);
  void find_slots(const Mesh& mesh, const std::vector<CellGroup>& groups, const Adjacency& near);
};

} // namespace impact
