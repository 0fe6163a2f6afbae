#include <impact/mesh/partition.hpp>
#include <impact/petsc/error.hpp>
#include <metis.h>
#include <numeric>
#include <petsc/private/partitionerimpl.h>
#include <vector>

// Outside of our namespace, where impact::PetscError would hide the function that PETSc's macros call.
namespace {

// Part of each vertex. METIS itself is not made for as many parts as vertices.
int metis_parts(PetscInt parts, PetscInt vertices, const PetscInt* start, const PetscInt* neighbour,
                const idx_t* weight, std::vector<idx_t>& part) {
  part.assign(static_cast<std::size_t>(vertices), 0);
  if (parts == 1) return METIS_OK;
  if (vertices <= parts) {
    std::iota(part.begin(), part.end(), idx_t{0});
    return METIS_OK;
  }
  std::vector<idx_t> from(start, start + vertices + 1), to(neighbour, neighbour + start[vertices]);
  idx_t n = static_cast<idx_t>(vertices), constraints = 1, part_count = static_cast<idx_t>(parts), cut = 0;
  idx_t options[METIS_NOPTIONS];
  METIS_SetDefaultOptions(options);
  options[METIS_OPTION_NUMBERING] = 0;
  options[METIS_OPTION_SEED] = 1;
  return METIS_PartGraphKway(&n, &constraints, from.data(), to.data(), const_cast<idx_t*>(weight), nullptr,
                             nullptr, &part_count, nullptr, nullptr, options, &cut, part.data());
}

PetscErrorCode partition(PetscPartitioner self, PetscInt parts, PetscInt vertices, PetscInt start[],
                         PetscInt neighbour[], PetscSection weights, PetscSection,
#if PETSC_VERSION_GE(3, 21, 0)
                         PetscSection,
#endif
                         PetscSection result, IS* order) {
  PetscFunctionBegin;
  const MPI_Comm comm = PetscObjectComm(reinterpret_cast<PetscObject>(self));
  int holding = vertices > 0 ? 1 : 0, holders = 0;
  PetscCallMPI(MPI_Allreduce(&holding, &holders, 1, MPI_INT, MPI_SUM, comm));
  PetscCheck(holders <= 1, comm, PETSC_ERR_SUP,
             "partitioner metis needs the whole mesh on one rank; use -petscpartitioner_type ptscotch");
  std::vector<idx_t> weight, part;
  if (weights && vertices > 0) {
    PetscInt first = 0, end = 0;
    PetscCall(PetscSectionGetChart(weights, &first, &end));
    for (PetscInt v = first; v < end && v < first + vertices; ++v) {
      PetscInt dofs = 0;
      PetscCall(PetscSectionGetDof(weights, v, &dofs));
      weight.push_back(static_cast<idx_t>(dofs));
    }
  }
  const bool weighted = static_cast<PetscInt>(weight.size()) == vertices && vertices > 0;
  PetscCheck(metis_parts(parts, vertices, start, neighbour, weighted ? weight.data() : nullptr, part) ==
                 METIS_OK,
             PETSC_COMM_SELF, PETSC_ERR_LIB, "METIS failed");
  std::vector<PetscInt> count(static_cast<std::size_t>(parts) + 1, 0), list(part.size());
  for (const idx_t p : part) ++count[static_cast<std::size_t>(p) + 1];
  for (PetscInt p = 0; p < parts; ++p)
    PetscCall(PetscSectionSetDof(result, p, count[static_cast<std::size_t>(p) + 1]));
  std::partial_sum(count.begin(), count.end(), count.begin());
  for (std::size_t v = 0; v < part.size(); ++v)
    list[static_cast<std::size_t>(count[static_cast<std::size_t>(part[v])]++)] = static_cast<PetscInt>(v);
  PetscCall(ISCreateGeneral(comm, vertices, list.data(), PETSC_COPY_VALUES, order));
  PetscFunctionReturn(0);
}

PetscErrorCode create(PetscPartitioner self) {
  PetscFunctionBegin;
  self->noGraph = PETSC_FALSE;
  self->ops->partition = partition;
  PetscFunctionReturn(0);
}

} // namespace

namespace impact {

void register_metis_partitioner() {
  static bool done = false; // PETSc's list of types is as global
  if (!done) check(PetscPartitionerRegister("metis", create));
  done = true;
}

} // namespace impact
