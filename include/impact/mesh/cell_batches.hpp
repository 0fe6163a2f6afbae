#pragma once
#include <impact/math/batch.hpp>
#include <impact/mesh/mesh.hpp>

/// Cells of equal shape and material packed lane by lane: the only place that knows lanes and padding. A
/// short last batch repeats its last cell; those lanes are never scattered or summed. Cells are in the mesh's
/// order (locality).
namespace impact {

struct CellGroup {
  Shape shape;
  int material = 0; ///< index into the run's list of materials
  int cell_count = 0, batch_count = 0;
  std::vector<int> node;             ///< [batch][node][lane] local node
  std::vector<PetscInt> cell_point;  ///< [batch][lane] DMPlex point (padding repeats)
  int lanes_in_use(int batch) const; ///< lanes of `batch` that hold a cell of their own
};

/// Packs all cells. `material_of_cell[p - mesh.cell_start()]` is the material index of DMPlex cell point p.
/// The list of groups (shape, material) is the same on all ranks, by rising material, then shape; a rank
/// without such cells has an empty group. Throws UserError(data) when a cell has no material (-1), naming its
/// coordinates. Collective.
std::vector<CellGroup> pack_cells(const Mesh& mesh, const std::vector<int>& material_of_cell);

/// The local nodes of one batch, [node][lane].
template <class Cell> const int* batch_nodes(const CellGroup& group, int batch) {
  return group.node.data() + static_cast<std::ptrdiff_t>(batch) * Cell::nodes * lanes;
}

/// Gathers `components` values per node of one batch from a local array [node][component].
/// out: [node][component] of Batch.
template <class Cell, int components>
void gather(const CellGroup& group, int batch, const double* local, Batch* out) {
  const int* node = batch_nodes<Cell>(group, batch);
  for (int a = 0; a < Cell::nodes; ++a) {
    const double* from[lanes];
    for (int l = 0; l < lanes; ++l)
      from[l] = local + static_cast<std::ptrdiff_t>(node[a * lanes + l]) * components;
    for (int k = 0; k < components; ++k)
      for (int l = 0; l < lanes; ++l) out[a * components + k].set(l, from[l][k]);
  }
}

/// Adds [node][component] of Batch to the local array; padding lanes are skipped.
template <class Cell, int components>
void scatter_add(const CellGroup& group, int batch, const Batch* values, double* local) {
  const int* node = batch_nodes<Cell>(group, batch);
  const int used = group.lanes_in_use(batch);
  for (int l = 0; l < used; ++l)
    for (int a = 0; a < Cell::nodes; ++a) {
      double* to = local + static_cast<std::ptrdiff_t>(node[a * lanes + l]) * components;
      for (int k = 0; k < components; ++k) to[k] += values[a * components + k][l];
    }
}

} // namespace impact
