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

/// Gathers `components` values per node of one batch from a local array [node][component].
/// out: [node][component] of Batch, nodes = number of nodes of the shape.
void gather(const CellGroup& group, int batch, int components, const double* local, Batch* out);
/// Adds [node][component] of Batch to the local array; padding lanes are skipped.
void scatter_add(const CellGroup& group, int batch, int components, const Batch* values, double* local);

} // namespace impact
