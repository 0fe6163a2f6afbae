#include "metis_parts.hpp"

#include <algorithm>
#include <cmath>
#include <impact/math/index.hpp>
#include <impact/mesh/mesh.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/log.hpp>
#include <impact/petsc/ranks.hpp>
#include <numeric>
#include <petsc/private/partitionerimpl.h>
#include <string_view>
#include <vector>

// Outside of our namespace, where impact::PetscError would hide the function that PETSc's macros call.
namespace {

constexpr const char* contact_part = "contact"; // section of it that the partitioner carries
constexpr const char* patch_part = "patch";     // patches of the vertices, or -1

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

// All vertices of a patch follow its first one. patch: [vertex] or empty; -1: of none.
void keep_together(const std::vector<idx_t>& patch, std::vector<idx_t>& part) {
  std::vector<idx_t> of_patch;
  for (std::size_t v = 0; v < patch.size(); ++v) {
    if (patch[v] < 0) continue;
    const auto p = static_cast<std::size_t>(patch[v]);
    if (of_patch.size() <= p) of_patch.resize(p + 1, -1);
    if (of_patch[p] < 0) of_patch[p] = part[v];
    part[v] = of_patch[p];
  }
}

// The patches of all vertices, on rank 0; empty where none are said.
PetscErrorCode gather_patches(PetscPartitioner self, PetscInt vertices, std::vector<int>& counts,
                              std::vector<idx_t>& patch) {
  IS kept = nullptr;
  const PetscInt* mine = nullptr;
  PetscFunctionBegin;
  PetscCall(PetscObjectQuery(reinterpret_cast<PetscObject>(self), patch_part,
                             reinterpret_cast<PetscObject*>(&kept)));
  if (!kept) PetscFunctionReturn(0);
  PetscCall(ISGetIndices(kept, &mine));
  patch = on_first_rank(PetscObjectComm(reinterpret_cast<PetscObject>(self)), mine, vertices, counts);
  PetscCall(ISRestoreIndices(kept, &mine));
  PetscFunctionReturn(0);
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
  PetscSection contact = nullptr; // part of the weights
  PetscCall(PetscObjectQuery(reinterpret_cast<PetscObject>(self), contact_part,
                             reinterpret_cast<PetscObject*>(&contact)));
  const int kinds = contact ? 2 : 1;
  std::vector<idx_t> degree, weight; // weight: [vertex][kind]
  PetscInt first = 0, end = 0;
  if (weights) PetscCall(PetscSectionGetChart(weights, &first, &end));
  for (PetscInt v = 0; v < vertices; ++v) {
    PetscInt all = 0, of_contact = 0;
    if (first + v < end) PetscCall(PetscSectionGetDof(weights, first + v, &all));
    if (contact) PetscCall(PetscSectionGetDof(contact, v, &of_contact));
    degree.push_back(start[v + 1] - start[v]);
    weight.push_back(std::max<PetscInt>(all - of_contact, 1)); // 1 where no weight is said
    if (contact) weight.push_back(of_contact);
  }
  std::vector<int> counts(rank == 0 ? static_cast<std::size_t>(ranks) : 0), ignored = counts;
  std::vector<idx_t> to = on_first_rank(comm, neighbour, vertices > 0 ? start[vertices] : 0, ignored),
                     weight_of = on_first_rank(comm, weight.data(), kinds * vertices, ignored),
                     from = on_first_rank(comm, degree.data(), vertices, counts), all,
                     part(static_cast<std::size_t>(vertices));
  from.insert(from.begin(), 0);
  std::partial_sum(from.begin(), from.end(), from.begin());
  std::vector<idx_t> patch;
  PetscCall(gather_patches(self, vertices, ignored, patch));
  int code = rank == 0 ? impact::metis_parts(parts, from, to, weight_of, kinds, all) : METIS_OK;
  keep_together(patch, all);
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

// What its cells cost a rank, in the order of the mesh.
struct CellCosts {
  std::vector<PetscInt> bulk, contact; // [cell]
  PetscInt first = 0, chart_first = 0, chart_end = 0;
};

CellCosts cell_costs(DM dm, const PartitionWeights& weights) {
  PetscInt end = 0, dim = 0;
  CellCosts costs;
  check(DMGetDimension(dm, &dim));
  check(DMPlexGetHeightStratum(dm, 0, &costs.first, &end));
  check(DMPlexGetChart(dm, &costs.chart_first, &costs.chart_end));
  if (costs.chart_end == costs.chart_first) costs.first = end = 0;
  costs.bulk.assign(at(end - costs.first), 1);
  costs.contact.assign(costs.bulk.size(), 0);
  for (const auto& [name, weight] : weights.region)
    for (const PetscInt cell : labelled_points(dm, name, dim))
      if (cell >= costs.first && cell < end) costs.bulk[at(cell - costs.first)] = std::max(1, weight);
  for (const auto& [name, weight] : weights.boundary)
    for (const PetscInt facet : labelled_points(dm, name, dim - 1)) {
      const PetscInt* support = nullptr;
      PetscInt count = 0;
      check(DMPlexGetSupport(dm, facet, &support));
      check(DMPlexGetSupportSize(dm, facet, &count));
      if (count > 0 && support[0] >= costs.first && support[0] < end)
        costs.contact[at(support[0] - costs.first)] += weight;
    }
  return costs;
}

// Total over all ranks, largest of a rank, smallest that costs anything.
struct RankCosts {
  double total = 0, most = 0, unit = HUGE_VAL;
};

RankCosts amount_of(MPI_Comm comm, const std::vector<PetscInt>& costs) {
  RankCosts amount;
  for (const PetscInt cost : costs) {
    amount.total += cost;
    if (cost > 0) amount.unit = std::min(amount.unit, static_cast<double>(cost));
  }
  amount.most = max_over_ranks(comm, amount.total);
  amount.total = sum_over_ranks(comm, amount.total);
  amount.unit = min_over_ranks(comm, amount.unit);
  return amount;
}

// Numbers of dofs: that is where DMPlex looks for vertex weights. `value`: of the points from `first` on.
Handle<PetscSection> section_of(MPI_Comm comm, PetscInt chart_first, PetscInt chart_end, PetscInt first,
                                const std::vector<PetscInt>& value) {
  Handle<PetscSection> section;
  check(PetscSectionCreate(comm, section.out()));
  check(PetscSectionSetNumFields(section, 1)); // before the chart, else PETSc 3.18 crashes
  check(PetscSectionSetChart(section, chart_first, chart_end));
  for (std::size_t c = 0; c < value.size(); ++c) {
    const PetscInt point = first + static_cast<PetscInt>(c);
    check(PetscSectionSetDof(section, point, value[c]));
    check(PetscSectionSetFieldDof(section, point, 0, value[c]));
  }
  check(PetscSectionSetUp(section));
  return section;
}

// All partitioners see the sum of the costs; ours sees the two kinds.
void set_weights(DM dm, PetscPartitioner partitioner, const PartitionWeights& weights) {
  const MPI_Comm comm = PetscObjectComm(reinterpret_cast<PetscObject>(dm));
  const CellCosts costs = cell_costs(dm, weights);
  std::vector<PetscInt> sum = costs.bulk;
  for (std::size_t c = 0; c < sum.size(); ++c) sum[c] += costs.contact[c];
  check(DMSetLocalSection(dm, section_of(comm, costs.chart_first, costs.chart_end, costs.first, sum)));
  if (!(amount_of(comm, costs.contact).total > 0)) return;
  check(PetscObjectCompose(
      reinterpret_cast<PetscObject>(partitioner), contact_part,
      reinterpret_cast<PetscObject>(
          section_of(comm, 0, static_cast<PetscInt>(sum.size()), 0, costs.contact).get())));
}

// Tells the partitioner which cells must not be parted.
void keep_patches(DM dm, PetscPartitioner partitioner, const std::vector<PetscInt>& patches) {
  const MPI_Comm comm = PetscObjectComm(reinterpret_cast<PetscObject>(dm));
  const auto count = static_cast<PetscInt>(patches.size());
  if (max_over_ranks(comm, static_cast<int>(count)) == 0) return;
  PetscPartitionerType type = nullptr;
  check(PetscPartitionerGetType(partitioner, &type));
  if (sum_over_ranks(comm, 1.0) > 1 && std::string_view(type) != "metis")
    throw UserError(ExitCode::usage, std::string("-petscpartitioner_type ") + type +
                                         ": may part linear triangles or tetrahedra that share their volume; "
                                         "allowed: metis, or -material_<id>_locking none");
  Handle<IS> kept;
  check(ISCreateGeneral(comm, count, patches.data(), PETSC_COPY_VALUES, kept.out()));
  check(PetscObjectCompose(reinterpret_cast<PetscObject>(partitioner), patch_part,
                           reinterpret_cast<PetscObject>(kept.get())));
}

// The patches of the cells where these are now.
void move_patches(DM before, DM after, PetscSF migration, std::vector<PetscInt>& patches) {
  if (max_over_ranks(PetscObjectComm(reinterpret_cast<PetscObject>(after)),
                     static_cast<int>(patches.size())) == 0)
    return;
  PetscInt end = 0, first = 0, last = 0;
  check(DMPlexGetChart(before, nullptr, &end));
  std::vector<PetscInt> from(at(end), -1);
  check(DMPlexGetHeightStratum(before, 0, &first, nullptr));
  std::copy(patches.begin(), patches.end(), from.begin() + first);
  check(DMPlexGetChart(after, nullptr, &end));
  std::vector<PetscInt> to(at(end), -1);
  check(PetscSFBcastBegin(migration, MPIU_INT, from.data(), to.data(), MPI_REPLACE));
  check(PetscSFBcastEnd(migration, MPIU_INT, from.data(), to.data(), MPI_REPLACE));
  check(DMPlexGetHeightStratum(after, 0, &first, &last));
  patches.assign(to.begin() + first, to.begin() + last);
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

// DMPlexPermute of PETSc 3.18 takes the number of coordinates of a point from another one: nodes amid
// quadrilaterals that stand beside triangles, or amid hexahedra beside tetrahedra, lose their places.
void place_points(DM before, IS new_number, DM after) {
  PetscSection from = nullptr, to = nullptr;
  PetscInt first = 0, end = 0;
  const PetscInt* number = nullptr;
  Vec old_places = nullptr, places = nullptr;
  const PetscScalar* x = nullptr;
  PetscScalar* y = nullptr;
  check(DMGetCoordinateSection(before, &from));
  check(DMGetCoordinateSection(after, &to));
  check(DMGetCoordinatesLocal(before, &old_places));
  check(DMGetCoordinatesLocal(after, &places));
  check(VecGetArrayRead(old_places, &x));
  check(VecGetArray(places, &y));
  check(ISGetIndices(new_number, &number));
  check(PetscSectionGetChart(from, &first, &end));
  for (PetscInt point = first; point < end; ++point) {
    PetscInt count = 0, old_offset = 0, offset = 0;
    check(PetscSectionGetDof(from, point, &count));
    if (count == 0) continue;
    check(PetscSectionGetOffset(from, point, &old_offset));
    check(PetscSectionGetOffset(to, number[point], &offset));
    std::copy_n(x + old_offset, count, y + offset);
  }
  check(ISRestoreIndices(new_number, &number));
  check(VecRestoreArray(places, &y));
  check(VecRestoreArrayRead(old_places, &x));
  check(DMSetCoordinatesLocal(after, places)); // the global ones are made afresh from these
}

} // namespace

Handle<PetscSF> distribute(Handle<DM>& dm, const PartitionWeights& weights, std::vector<PetscInt>& patches) {
  const Timed timed(Event::mesh_partition);
  register_metis_partitioner();
  PetscPartitioner partitioner = nullptr;
  check(DMPlexGetPartitioner(dm, &partitioner));
  check(PetscPartitionerSetType(partitioner, "metis"));
  check(PetscPartitionerSetFromOptions(partitioner));
  check(DMPlexDistributeSetDefault(dm, PETSC_FALSE));
  check(DMPlexSetPartitionBalance(dm, PETSC_TRUE)); // shares out the nodes between ranks
  set_weights(dm, partitioner, weights);
  keep_patches(dm, partitioner, patches);
  Handle<PetscSF> migration;
  Handle<DM> moved;
  PetscSF sf = nullptr;
  DM parallel = nullptr;
  check(DMPlexDistribute(dm, 0, &sf, &parallel));
  if (parallel) {
    migration = Handle<PetscSF>(sf);
    move_patches(dm, parallel, migration, patches);
    dm = Handle<DM>(parallel);
  }
  check(DMSetLocalSection(dm, nullptr));
  return migration;
}

bool evenly_shared(DM dm, const PartitionWeights& weights) {
  const MPI_Comm comm = PetscObjectComm(reinterpret_cast<PetscObject>(dm));
  const double ranks = sum_over_ranks(comm, 1.0);
  const CellCosts costs = cell_costs(dm, weights);
  for (const std::vector<PetscInt>& kind : {costs.bulk, costs.contact}) {
    const RankCosts amount = amount_of(comm, kind);
    if (amount.most * ranks > amount.total * even_share(amount.total, amount.unit, ranks)) return false;
  }
  return true;
}

void order_for_locality(Handle<DM>& dm, std::vector<PetscInt>& patches) {
  Handle<IS> order;
  Handle<DM> ordered;
  check(DMPlexGetOrdering(dm, MATORDERINGRCM, nullptr, order.out()));
  check(DMPlexPermute(dm, order, ordered.out()));
  renumber_shared_points(dm, order, ordered);
  place_points(dm, order, ordered);
  if (!patches.empty()) {
    const PetscInt* number = nullptr;
    PetscInt first = 0;
    check(DMPlexGetHeightStratum(dm, 0, &first, nullptr));
    check(ISGetIndices(order, &number));
    const std::vector<PetscInt> before = patches;
    for (std::size_t c = 0; c < before.size(); ++c) patches[at(number[at(first) + c] - first)] = before[c];
    check(ISRestoreIndices(order, &number));
  }
  dm = std::move(ordered);
}

} // namespace impact
