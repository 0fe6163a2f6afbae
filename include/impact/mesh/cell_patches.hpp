#pragma once
#include <array>
#include <impact/petsc/handle.hpp>
#include <string>
#include <vector>

/// Patches of linear triangles or tetrahedra: connected sets of some cells of one material, which share one
/// volume ratio (theory.md, volumetric locking).
namespace impact {

/// A triangle (three corners) or a tetrahedron: its material and the numbers of its corners.
struct PatchCell {
  int material;
  std::array<PetscInt, 4> corner;
};

/// The patch of each cell. A patch grows from the cell that has the fewest others left beside it, over
/// facets, by the cell that brings the fewest new nodes; what stays alone joins a neighbour. Cells that come
/// first win where others are as good.
std::vector<PetscInt> make_patches(int dim, const std::vector<PatchCell>& cells);

/// The patch of each cell of a mesh on any ranks, [cell of this rank]; -1 for cells of other shapes and of
/// other regions. `materials`: the regions of each. Patches hang on the places of the cells alone, not on
/// their numbers or ranks. Collective.
std::vector<PetscInt> find_patches(DM dm, const std::vector<std::vector<std::string>>& materials);

} // namespace impact
