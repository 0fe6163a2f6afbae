#include "metis_parts.hpp"

#include <algorithm>
#include <impact/math/index.hpp>
#include <impact/mesh/mesh.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/log.hpp>
#include <numeric>
#include <petsc/private/partitionerimpl.h>
#include <vector>

// Outside of our namespace, where impact::PetscError would hide the function that PETSc's macros call.
namespace {

// The numbers of all ranks, in their order, on rank 0; how many each has is told there too.
std::vector<idx_t> on_first_rank(MPI_Comm comm, const idx_t* mine, PetscInt size, std::vector<int>& counts) {
  const int own = static_cast<int>(size);
  MPI_Gather(&own, 1, MPI_INT, counts.data(), 1, MPI_INT, 0, comm);
  std::vector<int> from(counts.size() + 1, 0);
  std::partial_sum(counts.begin(), counts.end(), from.begin() + 1);
  std::vector<idx_t> all(static_cast<std::size_t>(from.back()));
  MPI_Gatherv(mine, own, MPIU_INT, all.data(), counts.data(), from.data(), MPIU_INT, 0, comm);
  return all;
}

// METIS works on one rank: the graph goes to rank 0, wherever its vertices are, and the parts come back.
PetscErrorCode partition(PetscPartitioner self, PetscInt parts, PetscInt vertices, PetscInt start[],
                         PetscInt neighbour[], PetscSection weights, PetscSection,
#if PETSC_VERSION_GE(3, 21, 0)
                         PetscSection,
#endif
                         PetscSection result, IS* order) {
  static_assert(sizeof(idx_t) == sizeof(PetscInt));
  PetscFunctionBegin;
  const MPI_Comm comm = PetscObjectComm(reinterpret_cast<PetscObject>(self));
  int rank = 0, ranks = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &ranks);
  std::vector<idx_t> degree, weight;
  PetscInt first = 0, end = 0;
  if (weights) PetscCall(PetscSectionGetChart(weights, &first, &end));
  for (PetscInt v = 0; v < vertices; ++v) {
    PetscInt dofs = 0;
    if (first + v < end) PetscCall(PetscSectionGetDof(weights, first + v, &dofs));
    degree.push_back(start[v + 1] - start[v]);
    weight.push_back(std::max<PetscInt>(dofs, 1)); // 1 where no weight is said
  }
  std::vector<int> counts(rank == 0 ? static_cast<std::size_t>(ranks) : 0), ignored = counts;
  std::vector<idx_t> to = on_first_rank(comm, neighbour, vertices > 0 ? start[vertices] : 0, ignored),
                     weight_of = on_first_rank(comm, weight.data(), vertices, ignored),
                     from = on_first_rank(comm, degree.data(), vertices, counts), all,
                     part(static_cast<std::size_t>(vertices));
  from.insert(from.begin(), 0);
  std::partial_sum(from.begin(), from.end(), from.begin());
  int code = rank == 0 ? impact::metis_parts(parts, from, to, weight_of.data(), all) : METIS_OK;
  MPI_Bcast(&code, 1, MPI_INT, 0, comm);
  PetscCheck(code == METIS_OK, comm, PETSC_ERR_LIB, "METIS failed");
  std::vector<int> place(counts.size() + 1, 0);
  std::partial_sum(counts.begin(), counts.end(), place.begin() + 1);
  MPI_Scatterv(all.data(), counts.data(), place.data(), MPIU_INT, part.data(), static_cast<int>(vertices),
               MPIU_INT, 0, comm);
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

namespace {

// Makes the partitioner type `metis` known to PETSc (Debian's PETSc is built without METIS). It takes vertex
// weights from the DM's local section. Equal input gives equal parts.
void register_metis_partitioner() {
  static bool done = false; // PETSc's list of types is as global
  if (!done) check(PetscPartitionerRegister("metis", create));
  done = true;
}

// Cost of a cell = its dofs in a section: that is where DMPlex looks for vertex weights.
Handle<PetscSection> weight_section(DM dm, const PartitionWeights& weights) {
  PetscInt first = 0, end = 0, chart_first = 0, chart_end = 0, dim = 0;
  check(DMGetDimension(dm, &dim));
  check(DMPlexGetHeightStratum(dm, 0, &first, &end));
  check(DMPlexGetChart(dm, &chart_first, &chart_end));
  if (chart_end == chart_first) first = end = 0;
  std::vector<PetscInt> cost(at(chart_end - chart_first), 0); // [point]
  std::fill(cost.begin() + first, cost.begin() + end, 1);
  for (const auto& [name, weight] : weights.region)
    for (const PetscInt cell : labelled_points(dm, name, dim))
      if (cell >= first && cell < end) cost[at(cell)] = std::max(1, weight);
  for (const auto& [name, weight] : weights.boundary)
    for (const PetscInt facet : labelled_points(dm, name, dim - 1)) {
      const PetscInt* support = nullptr;
      PetscInt count = 0;
      check(DMPlexGetSupport(dm, facet, &support));
      check(DMPlexGetSupportSize(dm, facet, &count));
      if (count > 0 && support[0] >= first && support[0] < end) cost[at(support[0])] += weight;
    }
  Handle<PetscSection> section;
  check(PetscSectionCreate(PetscObjectComm(reinterpret_cast<PetscObject>(dm)), section.out()));
  check(PetscSectionSetNumFields(section, 1)); // before the chart, else PETSc 3.18 crashes
  check(PetscSectionSetChart(section, chart_first, chart_end));
  for (PetscInt c = first; c < end; ++c) {
    check(PetscSectionSetDof(section, c, cost[at(c)]));
    check(PetscSectionSetFieldDof(section, c, 0, cost[at(c)]));
  }
  check(PetscSectionSetUp(section));
  return section;
}

// DMPlexPermute of PETSc 3.18 leaves the new mesh without the knowledge of which points other ranks share.
void renumber_shared_points(DM before, IS new_number, DM after) {
  PetscSF old_sf = nullptr, sf = nullptr;
  PetscInt roots = 0, leaves = 0;
  const PetscInt *number = nullptr, *leaf = nullptr;
  const PetscSFNode* remote = nullptr;
  check(DMGetPointSF(before, &old_sf));
  check(PetscSFGetGraph(old_sf, &roots, &leaves, &leaf, &remote));
  if (roots < 0) return;
  check(ISGetIndices(new_number, &number));
  std::vector<PetscInt> root_number(at(roots), -1), local;
  check(PetscSFBcastBegin(old_sf, MPIU_INT, number, root_number.data(), MPI_REPLACE));
  check(PetscSFBcastEnd(old_sf, MPIU_INT, number, root_number.data(), MPI_REPLACE));
  std::vector<PetscSFNode> node;
  for (PetscInt k = 0; k < leaves; ++k) {
    const PetscInt old = leaf ? leaf[k] : k;
    local.push_back(number[old]);
    node.push_back({remote[k].rank, root_number[at(old)]});
  }
  check(ISRestoreIndices(new_number, &number));
  check(DMGetPointSF(after, &sf));
  check(PetscSFSetGraph(sf, roots, leaves, local.data(), PETSC_COPY_VALUES, node.data(), PETSC_COPY_VALUES));
}

} // namespace

Handle<PetscSF> distribute(Handle<DM>& dm, const PartitionWeights& weights) {
  const Timed timed(Event::mesh_partition);
  register_metis_partitioner();
  PetscPartitioner partitioner = nullptr;
  check(DMPlexGetPartitioner(dm, &partitioner));
  check(PetscPartitionerSetType(partitioner, "metis"));
  check(PetscPartitionerSetFromOptions(partitioner));
  check(DMPlexDistributeSetDefault(dm, PETSC_FALSE));
  check(DMPlexSetPartitionBalance(dm, PETSC_TRUE)); // shares out the nodes between ranks
  check(DMSetLocalSection(dm, weight_section(dm, weights)));
  Handle<PetscSF> migration;
  Handle<DM> moved;
  PetscSF sf = nullptr;
  DM parallel = nullptr;
  check(DMPlexDistribute(dm, 0, &sf, &parallel));
  if (parallel) {
    dm = Handle<DM>(parallel);
    migration = Handle<PetscSF>(sf);
  }
  check(DMSetLocalSection(dm, nullptr));
  return migration;
}

void order_for_locality(Handle<DM>& dm) {
  Handle<IS> order;
  Handle<DM> ordered;
  check(DMPlexGetOrdering(dm, MATORDERINGRCM, nullptr, order.out()));
  check(DMPlexPermute(dm, order, ordered.out()));
  renumber_shared_points(dm, order, ordered);
  dm = std::move(ordered);
}

} // namespace impact
