#pragma once
#include <impact/io/hdf5_writer.hpp>
#include <impact/mesh/cell_batches.hpp>
#include <impact/mesh/state_table.hpp>

/// The parts of a mesh that carry state, recognised by keys that depend neither on ranks nor on numbering:
/// what one run writes in the order of its ranks another one finds on its own.
namespace impact {

/// Vertices, cells or the facets of a surface: first those that this rank writes, then those whose values
/// another rank writes too (ghosts). A set with one entity on rank 0 and one ghost on all others holds what
/// is global.
struct Entities {
  std::string name;
  hdf5::Slab slab; ///< of those that this rank writes
  /// [entity][2]: numbers made of the coordinates and regions of the cells around it. Integers below 2^53, so
  /// that sums over ranks are exact in any order.
  std::vector<double> keys;
};

/// The sets that a row of the state table needs: "vertex", "cell", "facet_<surface>" or "global". Collective.
std::vector<Entities> entities_of(const Mesh& mesh, const StateTable& table);
std::string entities_name(const StateRow& row);

/// Doubles that each entity takes in a file: the most that one has on any rank, so that smaller cells of a
/// mixed mesh leave some of theirs zero. Throws std::logic_error on all ranks for a row that has not the size
/// of its mesh. Collective.
std::size_t row_width(const Mesh& mesh, const std::vector<CellGroup>& groups, const StateRow& row);

/// Where the doubles of an entity stand in a row: `count` of them, `stride` apart from `at` on.
struct RowPlace {
  std::size_t entity, at, count, stride;
};
/// Calls `use` for the entities of a row that this rank writes, or for all places of the row: those of ghosts
/// and of lanes that pad a batch, which repeat others, as well. Returns the size of the row.
std::size_t for_each_place(const Mesh& mesh, const std::vector<CellGroup>& groups, const StateRow& row,
                           bool all, const std::function<void(const RowPlace&)>& use);

/// For each entity of this rank, ghosts included, the place of its key among those that are known ([k][2],
/// each rank a part that begins at `first`); -1 where there is none or more than one. Keys meet on a rank
/// that they name, so that no rank needs them all. Collective.
std::vector<PetscInt> find_keys(MPI_Comm comm, const std::vector<double>& known, PetscInt first,
                                const std::vector<double>& wanted);

} // namespace impact
