#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <impact/math/index.hpp>
#include <impact/mesh/gmsh.hpp>
#include <impact/mesh/mesh.hpp>
#include <impact/petsc/log.hpp>
#include <impact/petsc/ranks.hpp>
#include <limits>
#include <sstream>

namespace impact {

namespace {

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
  for (const GmshBlock& block : file.blocks) {
    if (block.dim != file.dim) continue;
    const Shape shape = block.shape();
    for (std::size_t k = 0; k < block.node.size(); k += at(block.nodes)) {
      PetscInt cone[max_nodes];
      for (int a = 0; a < block.nodes; ++a) cone[shape->from_plex[at(a)]] = cells + block.node[k + at(a)];
      check(DMPlexSetCone(bare, cell++, cone));
    }
  }
  check(DMPlexSymmetrize(bare));
  check(DMPlexStratify(bare));
  check(DMPlexInterpolate(bare, dm.out()));
  return dm;
}

void set_coordinates(DM dm, const GmshFile& file, double scale) {
  std::vector<PetscReal> x;
  for (std::size_t i = 0; i < file.x.size(); ++i)
    if (i % 3 < at(file.dim)) x.push_back(scale * file.x[i]);
  check(DMPlexBuildCoordinatesFromCellList(dm, file.dim, x.data()));
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
  const double cells = sum_over_ranks(comm, static_cast<double>(end - first));
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
  GmshBlock block{file.dim, static_cast<int>(cell.corner.size()), {static_cast<int>(file.groups.size())}, {}};
  for (const std::array<double, 3>& X : cell.corner) {
    block.node.push_back(static_cast<int>(file.x.size() / 3));
    for (double component : X) file.x.push_back(component / scale);
  }
  file.groups.push_back({cell.region, file.dim, 0});
  file.blocks.insert(file.blocks.begin(), std::move(block));
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
  // DMPlex refines cells of one kind after the other, simplices first; on several ranks they are sent so.
  if (request.refine > 0) std::ranges::stable_sort(file.blocks, {}, &GmshBlock::nodes);
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
