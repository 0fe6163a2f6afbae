#pragma once
#include <impact/math/index.hpp>
#include <impact/mesh/mesh.hpp>
#include <impact/petsc/error.hpp>
#include <petscvec.h>
#include <vector>

namespace impact {

/// f = 0 at owned local dofs of a nodal field: prescribed ones have no residual.
inline void zero_owned(Vec f, const Mesh& mesh, int components, const std::vector<int>& dofs) {
  double* values = nullptr;
  PetscInt start = 0;
  check(VecGetOwnershipRange(f, &start, nullptr));
  check(VecGetArray(f, &values));
  for (int dof : dofs)
    values[mesh.global_node()[at(dof / components)] * components + dof % components - start] = 0;
  check(VecRestoreArray(f, &values));
}

} // namespace impact
