#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <impact/mesh/agreed_error.hpp>
#include <impact/mesh/gmsh.hpp>
#include <impact/mesh/mesh.hpp>
#include <impact/mesh/partition.hpp>
#include <impact/petsc/log.hpp>
#include <limits>
#include <sstream>

namespace impact {

namespace {

std::size_t at(PetscInt k) { return static_cast<std::size_t>(k); }

GmshFile read_file(const MeshRequest& request) {
  const std::string ending = std::filesystem::path(request.file).extension().string();
  if (ending != ".msh" && ending != ".geo")
    throw UserError(ExitCode::usage, request.file + ": unknown kind of mesh file; allowed .msh and .geo");
  if (!std::filesystem::exists(request.file)) throw UserError(ExitCode::io, request.file + ": no such file");
  if (!(request.scale > 0) || !std::isfinite(request.scale))
    throw UserError(ExitCode::usage, "mesh scale must be positive and finite");
  if (ending == ".geo") return read_gmsh(run_gmsh(request));
  if (!request.parameters.empty())
    throw UserError(ExitCode::usage,
                    request.file + ": -mesh_set_" + request.parameters.begin()->first + " needs a .geo file");
  return read_gmsh(request.file);
}

DMPolytopeType polytope(int dim, int nodes) {
  for (const Shape shape : known_shapes())
    for (int type = 0; type < DM_NUM_POLYTOPES; ++type)
      if (shape->dim == dim && shape->nodes == nodes &&
          shape->names.polytope == std::string(DMPolytopeTypes[type]))
        return static_cast<DMPolytopeType>(type);
  throw UserError(ExitCode::data, "mesh: no cell has " + std::to_string(nodes) + " nodes");
}

PetscInt count_cells(const GmshFile& file) {
  PetscInt count = 0;
  for (const GmshBlock& block : file.blocks)
    if (block.dim == file.dim) count += static_cast<PetscInt>(block.node.size()) / block.nodes;
  return count;
}

// Cells and vertices only; the file is empty but for its dimension on all ranks but the first.
Handle<DM> make_topology(MPI_Comm comm, const GmshFile& file) {
  Handle<DM> bare, dm;
  const PetscInt cells = count_cells(file), nodes = static_cast<PetscInt>(file.x.size() / 3);
  check(DMPlexCreate(comm, bare.out()));
  check(DMSetDimension(bare, file.dim));
  check(DMPlexSetChart(bare, 0, cells + nodes));
  PetscInt cell = 0;
  for (const GmshBlock& block : file.blocks)
    for (std::size_t k = 0; block.dim == file.dim && k < block.node.size(); k += at(block.nodes))
      check(DMPlexSetConeSize(bare, cell++, block.nodes));
  check(DMSetUp(bare));
  cell = 0;
  for (const GmshBlock& block : file.blocks)
    if (block.dim == file.dim) {
      const DMPolytopeType type = polytope(file.dim, block.nodes);
      for (std::size_t k = 0; k < block.node.size(); k += at(block.nodes)) {
        PetscInt cone[max_nodes];
        for (int a = 0; a < block.nodes; ++a) cone[a] = cells + block.node[k + at(a)];
        check(DMPlexInvertCell(type, cone)); // DMPlex's tetrahedra and hexahedra are mirrored
        check(DMPlexSetCone(bare, cell++, cone));
      }
    }
  check(DMPlexSymmetrize(bare));
  check(DMPlexStratify(bare));
  check(DMPlexInterpolate(bare, dm.out()));
  return dm;
}

void set_coordinates(DM dm, const GmshFile& file, double scale) {
  const PetscInt cells = count_cells(file), nodes = static_cast<PetscInt>(file.x.size() / 3), dim = file.dim;
  PetscSection section = nullptr;
  check(DMSetCoordinateDim(dm, dim));
  check(DMGetCoordinateSection(dm, &section));
  check(PetscSectionSetNumFields(section, 1));
  check(PetscSectionSetFieldComponents(section, 0, dim));
  check(PetscSectionSetChart(section, cells, cells + nodes));
  for (PetscInt n = cells; n < cells + nodes; ++n) {
    check(PetscSectionSetDof(section, n, dim));
    check(PetscSectionSetFieldDof(section, n, 0, dim));
  }
  check(PetscSectionSetUp(section));
  Handle<Vec> x;
  PetscScalar* value = nullptr;
  check(VecCreate(PETSC_COMM_SELF, x.out()));
  check(PetscObjectSetName(reinterpret_cast<PetscObject>(x.get()), "coordinates"));
  check(VecSetSizes(x, nodes * dim, PETSC_DETERMINE));
  check(VecSetBlockSize(x, dim));
  check(VecSetType(x, VECSTANDARD));
  check(VecGetArray(x, &value));
  for (PetscInt n = 0; n < nodes; ++n)
    for (PetscInt i = 0; i < dim; ++i) value[n * dim + i] = scale * file.x[at(3 * n + i)];
  check(VecRestoreArray(x, &value));
  check(DMSetCoordinatesLocal(dm, x));
}

// Elements of lower dimension are found among the points of the mesh by their vertices.
void label_elements(DM dm, const GmshFile& file) {
  const PetscInt cells = count_cells(file);
  PetscInt cell = 0;
  for (const GmshBlock& block : file.blocks)
    for (std::size_t k = 0; k < block.node.size(); k += at(block.nodes)) {
      PetscInt point = 0, vertex[max_nodes], found = 0;
      const PetscInt* join = nullptr;
      for (int a = 0; a < block.nodes; ++a) vertex[a] = cells + block.node[k + at(a)];
      if (block.dim == file.dim) {
        point = cell++;
      } else if (block.dim == 0) {
        point = vertex[0];
      } else {
        check(DMPlexGetFullJoin(dm, block.nodes, vertex, &found, &join));
        PetscInt depth = -1; // the join of a diagonal is the whole cell
        point = found == 1 ? join[0] : -1;
        if (point >= 0) check(DMPlexGetPointDepth(dm, point, &depth));
        if (depth != block.dim) point = -1;
        check(DMPlexRestoreJoin(dm, block.nodes, vertex, &found, &join)); // also clears `found`
        if (point < 0 && !block.groups.empty())
          throw UserError(ExitCode::data,
                          "mesh: an element of group \"" + file.groups[at(block.groups[0])].name +
                              "\" is no facet or edge of a cell; all cells must have the same dimension");
      }
      for (const int g : block.groups)
        check(DMSetLabelValue(dm, file.groups[at(g)].name.c_str(), point, file.groups[at(g)].dim));
    }
}

// Rank 0's groups on all ranks.
std::vector<Group> share_groups(MPI_Comm comm, const std::vector<GmshGroup>& groups) {
  std::string text;
  for (const GmshGroup& g : groups) text += std::to_string(g.dim) + g.name + '\n';
  std::istringstream lines(broadcast(comm, text));
  std::vector<Group> shared;
  for (std::string line; std::getline(lines, line);) shared.push_back({line.substr(1), line[0] - '0'});
  return shared;
}

// Cost of a cell = its dofs in a section: that is where DMPlex looks for vertex weights.
Handle<PetscSection> weight_section(DM dm, const PartitionWeights& weights) {
  Handle<PetscSection> section;
  PetscInt first = 0, end = 0, chart_first = 0, chart_end = 0;
  check(DMPlexGetHeightStratum(dm, 0, &first, &end));
  check(DMPlexGetChart(dm, &chart_first, &chart_end));
  if (chart_end == chart_first) first = end = 0;
  std::vector<PetscInt> cost(at(end - first), 1);
  const auto for_each_point = [&](const std::string& name, PetscInt dim, auto&& body) {
    Handle<IS> points;
    const PetscInt* point = nullptr;
    PetscInt count = 0;
    DMLabel label = nullptr;
    check(DMGetLabel(dm, name.c_str(), &label));
    if (label) check(DMLabelGetStratumIS(label, dim, points.out()));
    if (!points) return;
    check(ISGetLocalSize(points, &count));
    check(ISGetIndices(points, &point));
    for (PetscInt k = 0; k < count; ++k) body(point[k]);
    check(ISRestoreIndices(points, &point));
  };
  PetscInt dim = 0;
  check(DMGetDimension(dm, &dim));
  for (const auto& [name, weight] : weights.region)
    for_each_point(name, dim, [&](PetscInt cell) {
      if (cell >= first && cell < end) cost[at(cell - first)] = std::max(1, weight);
    });
  for (const auto& [name, weight] : weights.boundary)
    for_each_point(name, dim - 1, [&](PetscInt facet) {
      const PetscInt* support = nullptr;
      PetscInt count = 0;
      check(DMPlexGetSupport(dm, facet, &support));
      check(DMPlexGetSupportSize(dm, facet, &count));
      if (count > 0 && support[0] >= first && support[0] < end) cost[at(support[0] - first)] += weight;
    });
  check(PetscSectionCreate(PetscObjectComm(reinterpret_cast<PetscObject>(dm)), section.out()));
  check(PetscSectionSetNumFields(section, 1));
  check(PetscSectionSetChart(section, chart_first, chart_end));
  for (PetscInt c = first; c < end; ++c) {
    check(PetscSectionSetDof(section, c, cost[at(c - first)]));
    check(PetscSectionSetFieldDof(section, c, 0, cost[at(c - first)]));
  }
  check(PetscSectionSetUp(section));
  return section;
}

void refine(Handle<DM>& dm, int times) {
  for (int k = 0; k < times; ++k) {
    Handle<DM> fine;
    check(DMPlexSetRefinementUniform(dm, PETSC_TRUE));
    check(DMRefine(dm, PetscObjectComm(reinterpret_cast<PetscObject>(dm.get())), fine.out()));
    check(DMSetCoarseDM(fine, nullptr));
    dm = std::move(fine);
  }
}

// A refinement too many asks for all memory there is.
void check_size(MPI_Comm comm, DM dm, int dim, const MeshRequest& request) {
  if (request.refine == 0) return;
  PetscInt first = 0, end = 0;
  check(DMPlexGetHeightStratum(dm, 0, &first, &end));
  double cells = end - first;
  MPI_Allreduce(MPI_IN_PLACE, &cells, 1, MPI_DOUBLE, MPI_SUM, comm);
  const double refined = cells * std::pow(2.0, dim * request.refine);
  char text[200];
  std::snprintf(text, sizeof(text), "mesh of %.0f cells, %.4g after %d refinements", cells, refined,
                request.refine);
  if (refined > request.most_cells)
    throw UserError(ExitCode::data, std::string(text) + ": more than -mesh_cells " +
                                        std::to_string(static_cast<long long>(request.most_cells)) +
                                        "; refine less (-dm_refine), or allow as many by -mesh_cells");
  check(PetscPrintf(comm, "%s\n", text));
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
  std::vector<PetscInt> root_number(at(roots), -1);
  check(PetscSFBcastBegin(old_sf, MPIU_INT, number, root_number.data(), MPI_REPLACE));
  check(PetscSFBcastEnd(old_sf, MPIU_INT, number, root_number.data(), MPI_REPLACE));
  std::vector<std::pair<PetscInt, PetscSFNode>> shared;
  for (PetscInt k = 0; k < leaves; ++k) {
    const PetscInt old = leaf ? leaf[k] : k;
    shared.push_back({number[old], {remote[k].rank, root_number[at(old)]}});
  }
  check(ISRestoreIndices(new_number, &number));
  std::sort(shared.begin(), shared.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  PetscInt* local = nullptr;
  PetscSFNode* node = nullptr;
  check(PetscMalloc1(leaves, &local));
  check(PetscMalloc1(leaves, &node));
  for (PetscInt k = 0; k < leaves; ++k) {
    local[k] = shared[at(k)].first;
    node[k] = shared[at(k)].second;
  }
  check(DMGetPointSF(after, &sf));
  check(PetscSFSetGraph(sf, roots, leaves, local, PETSC_OWN_POINTER, node, PETSC_OWN_POINTER));
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

std::vector<Group> groups_from_labels(DM dm) {
  PetscInt count = 0;
  std::vector<Group> groups;
  check(DMGetNumLabels(dm, &count));
  for (PetscInt k = 0; k < count; ++k) {
    const char* name = nullptr;
    DMLabel label = nullptr;
    check(DMGetLabelName(dm, k, &name));
    check(DMGetLabelByNum(dm, k, &label));
    if (std::string(name) == "depth" || std::string(name) == "celltype") continue;
    PetscInt mine = -1, dim = -1;
    for (PetscInt d = 0; d <= 3; ++d) {
      PetscInt size = 0;
      check(DMLabelGetStratumSize(label, d, &size));
      if (size > 0) mine = d;
    }
    MPI_Allreduce(&mine, &dim, 1, MPIU_INT, MPI_MAX, PetscObjectComm(reinterpret_cast<PetscObject>(dm)));
    if (dim >= 0) groups.push_back({name, static_cast<int>(dim)});
  }
  return groups;
}

namespace {

std::array<double, 6> box_of(const GmshFile& file, double scale) {
  constexpr double far = std::numeric_limits<double>::infinity();
  std::array<double, 6> box = {far, far, far, -far, -far, -far};
  for (std::size_t i = 0; i < file.x.size(); ++i) {
    box[i % 3] = std::min(box[i % 3], scale * file.x[i]);
    box[3 + i % 3] = std::max(box[3 + i % 3], scale * file.x[i]);
  }
  return box;
}

void append(GmshFile& file, const AddedCell& cell, double scale) {
  for (const GmshGroup& group : file.groups)
    if (group.name == cell.region)
      throw UserError(ExitCode::data, "mesh: has a group \"" + cell.region +
                                          "\", a name that the program needs for the body of a rigid "
                                          "obstacle with mass; rename one of them");
  GmshBlock block;
  block.dim = file.dim;
  block.nodes = static_cast<int>(cell.corner.size());
  block.groups = {static_cast<int>(file.groups.size())};
  for (const std::array<double, 3>& X : cell.corner) {
    block.node.push_back(static_cast<int>(file.x.size() / 3));
    for (double component : X) file.x.push_back(component / scale);
  }
  file.groups.push_back({cell.region, file.dim, 0});
  file.blocks.insert(file.blocks.begin(), std::move(block)); // DMPlex refines simplices before other cells
}

} // namespace

GmshFile read_mesh_file(MPI_Comm comm, const MeshRequest& request) {
  const bool geometry = request.file.ends_with(".geo");
  const Timed timed(geometry ? Event::mesh_gmsh : Event::mesh_read);
  GmshFile file;
  if (geometry)
    check(PetscPrintf(comm, "gmsh meshes %s, for %.0f s at most (-mesh_wall)\n", request.file.c_str(),
                      request.patience));
  on_rank_zero(comm, [&] { file = read_file(request); });
  return file;
}

Mesh read_mesh(MPI_Comm comm, const MeshRequest& request) {
  return build_mesh(comm, request, read_mesh_file(comm, request));
}

Mesh build_mesh(MPI_Comm comm, const MeshRequest& request, GmshFile file) {
  const Timed timed(Event::mesh_build);
  MPI_Bcast(&file.dim, 1, MPI_INT, 0, comm);
  if (request.add) {
    std::array<double, 6> box = box_of(file, request.scale);
    MPI_Bcast(box.data(), 6, MPI_DOUBLE, 0, comm);
    const std::vector<AddedCell> added = request.add(file.dim, box);
    on_rank_zero(comm, [&] {
      for (const AddedCell& cell : added) append(file, cell, request.scale);
    });
  }
  std::vector<Group> groups = share_groups(comm, file.groups);
  Handle<DM> dm = make_topology(comm, file);
  set_coordinates(dm, file, request.scale);
  for (const Group& g : groups) check(DMCreateLabel(dm, g.name.c_str()));
  on_rank_zero(comm, [&] { label_elements(dm, file); });
  check_size(comm, dm, file.dim, request);
  file = GmshFile();
  distribute(dm, request.weights);
  refine(dm, request.refine);
  order_for_locality(dm);
  check(PetscObjectSetName(reinterpret_cast<PetscObject>(dm.get()), "mesh"));
  return Mesh(std::move(dm), std::move(groups));
}

} // namespace impact
