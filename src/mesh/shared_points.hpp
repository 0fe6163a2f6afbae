#pragma once
#include <impact/petsc/error.hpp>
#include <petscdmplex.h>
#include <petscsf.h>
#include <vector>

/// Values at the points of a DMPlex, [point], on ranks that share points. Collective.
namespace impact {

/// The point SF, or null on a DM that has none because it lies on one rank.
inline PetscSF point_sf(DM dm) {
  PetscSF sf = nullptr;
  PetscInt roots = 0;
  check(DMGetPointSF(dm, &sf));
  check(PetscSFGetGraph(sf, &roots, nullptr, nullptr, nullptr));
  return roots >= 0 ? sf : nullptr;
}

/// All ranks get the owner's value.
template <class T> void copy_from_owners(DM dm, MPI_Datatype type, std::vector<T>& value) {
  const PetscSF sf = point_sf(dm);
  if (!sf) return;
  const std::vector<T> root = value;
  check(PetscSFBcastBegin(sf, type, root.data(), value.data(), MPI_REPLACE));
  check(PetscSFBcastEnd(sf, type, root.data(), value.data(), MPI_REPLACE));
}

/// The owner gets what `op` makes of the values of all ranks.
inline void reduce_to_owners(DM dm, MPI_Op op, std::vector<int>& value) {
  const PetscSF sf = point_sf(dm);
  if (!sf) return;
  const std::vector<int> leaf = value;
  check(PetscSFReduceBegin(sf, MPI_INT, leaf.data(), value.data(), op));
  check(PetscSFReduceEnd(sf, MPI_INT, leaf.data(), value.data(), op));
}

} // namespace impact
