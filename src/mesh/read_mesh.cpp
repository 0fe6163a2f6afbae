#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <impact/math/index.hpp>
#include <impact/mesh/agreed_error.hpp>
#include <impact/mesh/cell_patches.hpp>
#include <impact/mesh/gmsh.hpp>
#include <impact/mesh/mesh.hpp>
#include <impact/petsc/log.hpp>
#include <impact/petsc/ranks.hpp>
#include <limits>

namespace impact {

namespace {

GmshFile read_file(const MeshRequest& request) {
  const std::string ending = std::filesystem::path(request.file).extension().string();
  if (ending != ".msh" && ending != ".geo")
    throw UserError(ExitCode::usage, request.file +
                                         ": unknown kind of mesh file; allowed .msh, .geo, and .h5 as "
                                         "-mesh_convert writes it");
  if (!std::filesystem::exists(request.file)) throw UserError(ExitCode::io, request.file + ": no such file");
  check_request(request);
  return read_gmsh(ending == ".geo" ? run_gmsh(request) : request.file);
}

PetscInt count_cells(const GmshFile& file) {
  PetscInt count = 0;
  for (const GmshBlock& block : file.blocks)
    if (block.dim == file.dim) count += static_cast<PetscInt>(block.node.size()) / block.nodes;
  return count;
}

// body(nodes, shape) for the cells of this rank's part, in their order.
template <class Body> void for_each_cell(const GmshFile& file, Body&& body) {
  for (const GmshBlock& block : file.blocks) {
    if (block.dim != file.dim) continue;
    const Shape shape = block.shape();
    for (std::size_t k = 0; k < block.node.size(); k += at(block.nodes)) body(&block.node[k], shape);
  }
}

/// Nodes of a file that this rank's cells use.
struct FileNodes {
  std::vector<PetscInt> number; // in the file, rising
  Handle<PetscSF> of_file;      // from the nodes of all parts of the file to these

  FileNodes(MPI_Comm comm, const GmshFile& file, std::vector<PetscInt> used) : number(std::move(used)) {
    std::sort(number.begin(), number.end());
    number.erase(std::unique(number.begin(), number.end()), number.end());
    number.shrink_to_fit();
    PetscLayout nodes = nullptr;
    check(
        PetscLayoutCreateFromSizes(comm, static_cast<PetscInt>(file.x.size() / 3), PETSC_DECIDE, 1, &nodes));
    check(PetscSFCreate(comm, of_file.out()));
    check(PetscSFSetGraphLayout(of_file, nodes, static_cast<PetscInt>(number.size()), nullptr,
                                PETSC_COPY_VALUES, number.data()));
    check(PetscLayoutDestroy(&nodes));
  }
  std::vector<std::array<double, 3>> places(const GmshFile& file) const {
    std::vector<std::array<double, 3>> X(number.size());
    MPI_Datatype place = MPI_DATATYPE_NULL;
    MPI_Type_contiguous(3, MPI_DOUBLE, &place);
    MPI_Type_commit(&place);
    check(PetscSFBcastBegin(of_file, place, file.x.data(), X.data(), MPI_REPLACE));
    check(PetscSFBcastEnd(of_file, place, file.x.data(), X.data(), MPI_REPLACE));
    MPI_Type_free(&place);
    return X;
  }
  /// Place among these nodes; -1 where no cell of this rank has the node.
  PetscInt find(PetscInt node) const {
    const bool all = !number.empty() && number.back() + 1 == static_cast<PetscInt>(number.size());
    if (all && node < static_cast<PetscInt>(number.size())) return node;
    const auto found = std::lower_bound(number.begin(), number.end(), node);
    return found == number.end() || *found != node ? -1 : static_cast<PetscInt>(found - number.begin());
  }
};

// Corners of this rank's cells, or the nodes between them.
std::vector<PetscInt> used_nodes(const GmshFile& file, bool corners) {
  std::vector<PetscInt> used;
  for_each_cell(file, [&](const int* node, Shape shape) {
    const int middle = shape->corners();
    used.insert(used.end(), node + (corners ? 0 : middle), node + (corners ? middle : shape->nodes));
  });
  return used;
}

/// The cells of this rank's part of a file, and the vertices that they use: points of a mesh to be built.
struct Part {
  MPI_Comm comm;
  PetscInt cells;
  FileNodes vertex;

  Part(MPI_Comm all, const GmshFile& file)
      : comm(all), cells(count_cells(file)), vertex(all, file, used_nodes(file, true)) {}
  PetscInt end() const { return cells + static_cast<PetscInt>(vertex.number.size()); }
  /// -1 where no cell of this rank has the node.
  PetscInt point(PetscInt node) const {
    const PetscInt place = vertex.find(node);
    return place < 0 ? -1 : cells + place;
  }
};

// A vertex belongs to the first of the ranks whose cells use it.
void share_vertices(DM dm, const Part& part, PetscInt nodes_of_file) {
  int rank = 0, ranks = 1;
  MPI_Comm_rank(part.comm, &rank);
  MPI_Comm_size(part.comm, &ranks);
  if (ranks == 1) return;
  struct Owner {
    int rank = std::numeric_limits<int>::max(), point = 0;
  };
  std::vector<Owner> mine, owner(part.vertex.number.size()), of_node(at(nodes_of_file));
  for (PetscInt point = part.cells; point < part.end(); ++point) mine.push_back({rank, point});
  PetscSF of_file = part.vertex.of_file;
  check(PetscSFReduceBegin(of_file, MPI_2INT, mine.data(), of_node.data(), MPI_MINLOC));
  check(PetscSFReduceEnd(of_file, MPI_2INT, mine.data(), of_node.data(), MPI_MINLOC));
  check(PetscSFBcastBegin(of_file, MPI_2INT, of_node.data(), owner.data(), MPI_REPLACE));
  check(PetscSFBcastEnd(of_file, MPI_2INT, of_node.data(), owner.data(), MPI_REPLACE));
  std::vector<PetscInt> ghost;
  std::vector<PetscSFNode> at_owner;
  for (std::size_t v = 0; v < owner.size(); ++v)
    if (owner[v].rank != rank) {
      ghost.push_back(part.cells + static_cast<PetscInt>(v));
      at_owner.push_back({owner[v].rank, owner[v].point});
    }
  PetscSF shared = nullptr;
  check(DMGetPointSF(dm, &shared));
  check(PetscSFSetGraph(shared, part.end(), static_cast<PetscInt>(ghost.size()), ghost.data(),
                        PETSC_COPY_VALUES, at_owner.data(), PETSC_COPY_VALUES));
}

Handle<DM> make_topology(const Part& part, const GmshFile& file) {
  Handle<DM> bare, dm;
  check(DMPlexCreate(part.comm, bare.out()));
  check(DMSetDimension(bare, file.dim));
  check(DMPlexSetChart(bare, 0, part.end()));
  PetscInt cell = 0;
  for_each_cell(file,
                [&](const int*, Shape shape) { check(DMPlexSetConeSize(bare, cell++, shape->corners())); });
  check(DMSetUp(bare));
  cell = 0;
  for_each_cell(file, [&](const int* node, Shape shape) {
    PetscInt cone[max_nodes];
    const auto from_plex = linear(shape)->from_plex;
    for (std::size_t a = 0; a < from_plex.size(); ++a) cone[from_plex[a]] = part.point(node[a]);
    check(DMPlexSetCone(bare, cell++, cone));
  });
  check(DMPlexSymmetrize(bare));
  check(DMPlexStratify(bare));
  share_vertices(bare, part, static_cast<PetscInt>(file.x.size() / 3));
  check(DMPlexInterpolate(bare, dm.out()));
  return dm;
}

void set_coordinates(DM dm, const Part& part, const GmshFile& file, double scale) {
  std::vector<PetscReal> x;
  for (const auto& corner : part.vertex.places(file))
    for (std::size_t i = 0; i < at(file.dim); ++i) x.push_back(scale * corner[i]);
  check(DMPlexBuildCoordinatesFromCellList(dm, file.dim, x.data()));
}

// Nodes between the corners, where the file has them.
void set_middles(DM dm, MPI_Comm comm, const GmshFile& file, const MeshRequest& request) {
  int all = 0;
  for_each_cell(file, [&](const int*, Shape shape) { all = std::max(all, shape->faces.empty() ? 0 : 1); });
  all = max_over_ranks(comm, all);
  if (all && request.middles == Middles::edges)
    throw UserError(ExitCode::data, request.file +
                                        ": its cells have nodes in their middle, which -mesh_serendipity "
                                        "leaves out; mesh with Mesh.SecondOrderIncomplete = 1, or remove it");
  add_middles(dm, all ? Middles::all : Middles::edges);
  const NodeMap nodes = node_map(dm);
  const FileNodes middles(comm, file, used_nodes(file, false));
  const std::vector<std::array<double, 3>> X = middles.places(file);
  Vec coordinates = nullptr;
  PetscScalar* x = nullptr;
  check(DMGetCoordinatesLocal(dm, &coordinates));
  check(VecGetArray(coordinates, &x));
  PetscInt cell = 0;
  for_each_cell(file, [&](const int* node, Shape shape) {
    const std::vector<int> local = nodes_around(dm, nodes, cell++);
    for (int a = shape->corners(); a < shape->nodes; ++a)
      for (int i = 0; i < file.dim; ++i)
        x[local[at(shape->from_plex[at(a)])] * file.dim + i] =
            request.scale * X[at(middles.find(node[a]))][at(i)];
  });
  check(VecRestoreArray(coordinates, &x));
  check(DMSetCoordinatesLocal(dm, coordinates)); // the global ones are made afresh from these
}

// Elements of lower dimension are found among the points of the mesh by their vertices.
void label_elements(DM dm, const Part& part, const GmshFile& file) {
  PetscInt cell = 0;
  for (const GmshBlock& block : file.blocks)
    for (std::size_t k = 0; k < block.node.size(); k += at(block.nodes)) {
      const std::vector<int>& groups = file.sets[at(block.set)];
      PetscInt point = 0, vertex[max_nodes], found = 0;
      const PetscInt* join = nullptr;
      if (block.dim < file.dim)
        for (int a = 0; a < block.nodes; ++a) vertex[a] = part.point(block.node[k + at(a)]);
      if (block.dim == file.dim) {
        point = cell++;
      } else if (block.dim == 0 || *std::min_element(vertex, vertex + block.nodes) < 0) {
        point = vertex[0];
      } else {
        check(DMPlexGetFullJoin(dm, block.nodes, vertex, &found, &join));
        PetscInt depth = -1; // the join of a diagonal is the whole cell
        point = found == 1 ? join[0] : -1;
        if (point >= 0) check(DMPlexGetPointDepth(dm, point, &depth));
        if (depth != block.dim) point = -1;
        check(DMPlexRestoreJoin(dm, block.nodes, vertex, &found, &join)); // also clears `found`
      }
      if (point < 0 && !groups.empty())
        throw UserError(ExitCode::data,
                        "mesh: an element of group \"" + file.groups[at(groups[0])].name +
                            "\" is no facet or edge of a cell; all cells must have the same dimension");
      for (const int g : groups)
        check(DMSetLabelValue(dm, file.groups[at(g)].name.c_str(), point, file.groups[at(g)].dim));
    }
}

// An element of a boundary is said on one rank; others may share its points.
void share_labels(DM dm, const GmshFile& file) {
  PetscInt end = 0;
  check(DMPlexGetChart(dm, nullptr, &end));
  for (const GmshGroup& group : file.groups) {
    if (group.dim == file.dim) continue;
    std::vector<int> marked(at(end), 0);
    for (const PetscInt point : labelled_points(dm, group.name, group.dim)) marked[at(point)] = 1;
    share_points(dm, MPI_MAX, marked);
    for (PetscInt point = 0; point < end; ++point)
      if (marked[at(point)] != 0) check(DMSetLabelValue(dm, group.name.c_str(), point, group.dim));
  }
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

// Order of the cells of a file. Collective.
int order_of(MPI_Comm comm, const GmshFile& file) {
  int order = 1;
  for_each_cell(file, [&](const int*, Shape shape) { order = std::max(order, shape->order()); });
  return max_over_ranks(comm, order);
}

// What an order is asked for that the file cannot have.
void check_order(int order, const MeshRequest& request) {
  if (order == 1) return;
  if (request.order == 1)
    throw UserError(ExitCode::data, request.file + ": its cells are of second order, -order is 1; leave it "
                                                   "out, or mesh with first order (gmsh -order 1)");
  if (request.refine > 0)
    throw UserError(ExitCode::data,
                    request.file +
                        ": its cells are of second order, which -dm_refine cannot divide; allowed: "
                        "0; mesh with smaller cells, or with first order (gmsh -order 1), whose "
                        "straight edges -order 2 gives nodes after -dm_refine");
}

// Smallest and largest coordinates, of all ranks.
std::array<double, 6> box_of(MPI_Comm comm, const GmshFile& file, double scale) {
  constexpr double far = std::numeric_limits<double>::infinity();
  std::array<double, 3> low = {far, far, far}, high = {-far, -far, -far};
  for (std::size_t i = 0; i < file.x.size(); ++i) {
    low[i % 3] = std::min(low[i % 3], scale * file.x[i]);
    high[i % 3] = std::max(high[i % 3], scale * file.x[i]);
  }
  min_over_ranks(comm, low);
  max_over_ranks(comm, high);
  return {low[0], low[1], low[2], high[0], high[1], high[2]};
}

// The first rank has the cells that are added, the last one their nodes: no number in the file changes.
void append(MPI_Comm comm, GmshFile& file, const AddedCell& cell, double scale) {
  for (const GmshGroup& group : file.groups)
    if (group.name == cell.region)
      throw UserError(ExitCode::data, "mesh: has a group \"" + cell.region +
                                          "\", a name that the program needs for the body of a rigid "
                                          "obstacle with mass; rename one of them");
  int rank = 0, ranks = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &ranks);
  int node = sum_over_ranks(comm, static_cast<int>(file.x.size() / 3));
  GmshBlock block{file.dim, static_cast<int>(cell.corner.size()), static_cast<int>(file.sets.size()), {}};
  for (const std::array<double, 3>& X : cell.corner) {
    block.node.push_back(node++);
    for (double component : X)
      if (rank == ranks - 1) file.x.push_back(component / scale);
  }
  file.sets.push_back({static_cast<int>(file.groups.size())});
  file.groups.push_back({cell.region, file.dim, 0});
  if (rank == 0) file.blocks.insert(file.blocks.begin(), std::move(block));
}

} // namespace

void check_request(const MeshRequest& request) {
  if (!(request.scale > 0) || !std::isfinite(request.scale))
    throw UserError(ExitCode::usage, "mesh scale must be positive and finite");
  if (!request.parameters.empty() && !request.file.ends_with(".geo"))
    throw UserError(ExitCode::usage,
                    request.file + ": -mesh_set_" + request.parameters.begin()->first + " needs a .geo file");
}

GmshFile read_mesh_file(MPI_Comm comm, const MeshRequest& request) {
  const bool geometry = request.file.ends_with(".geo");
  const Timed timed(geometry ? Event::mesh_gmsh : Event::mesh_read);
  GmshFile file;
  if (geometry)
    check(PetscPrintf(comm, "gmsh meshes %s, for %.0f s at most (-mesh_wall)\n", request.file.c_str(),
                      request.patience));
  on_rank_zero(comm, [&] { file = read_file(request); });
  spread(comm, file);
  return file;
}

Mesh read_mesh(MPI_Comm comm, const MeshRequest& request) {
  return build_mesh(comm, request, read_mesh_file(comm, request));
}

Mesh build_mesh(MPI_Comm comm, const MeshRequest& request, GmshFile file) {
  const Timed timed(Event::mesh_build);
  if (request.add)
    for (const AddedCell& cell : request.add(file.dim, box_of(comm, file, request.scale)))
      append(comm, file, cell, request.scale);
  // DMPlex refines cells of one kind after the other, simplices first; on several ranks they are sent so.
  if (request.refine > 0) std::ranges::stable_sort(file.blocks, {}, &GmshBlock::nodes);
  std::vector<Group> groups;
  for (const GmshGroup& g : file.groups) groups.push_back({g.name, g.dim});
  const int order = order_of(comm, file);
  check_order(order, request);
  Handle<DM> dm;
  {
    const Part part(comm, file);
    dm = make_topology(part, file);
    set_coordinates(dm, part, file, request.scale);
    if (order == 2) set_middles(dm, comm, file, request);
    for (const Group& g : groups) check(DMCreateLabel(dm, g.name.c_str()));
    agree_on_errors(comm, [&] { label_elements(dm, part, file); });
    share_labels(dm, file);
  }
  check_size(comm, dm, file.dim, request);
  file = GmshFile();
  const bool patched = !request.patched.empty() && std::max(order, request.order) == 1;
  std::vector<PetscInt> patches;
  if (patched && request.refine == 0) patches = find_patches(dm, request.patched);
  distribute(dm, request.weights, patches);
  if (request.refine > 0) {
    refine(dm, request.refine);
    if (patched) patches = find_patches(dm, request.patched);
    // Where the file has few cells or facets for a rank, those of the refined mesh can be shared more evenly.
    if (patched || !evenly_shared(dm, request.weights)) distribute(dm, request.weights, patches);
  }
  order_for_locality(dm, patches);
  if (request.order > order) add_middles(dm, request.middles);
  check(PetscObjectSetName(reinterpret_cast<PetscObject>(dm.get()), "mesh"));
  return Mesh(std::move(dm), std::move(groups), std::move(patches));
}

} // namespace impact
