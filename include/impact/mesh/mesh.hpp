#pragma once
#include <array>
#include <functional>
#include <impact/kernel/shape.hpp>
#include <impact/mesh/node_map.hpp>
#include <impact/petsc/handle.hpp>
#include <map>
#include <span>
#include <string>
#include <vector>

/// The distributed mesh: topology, coordinates and named groups, immutable after construction (total
/// Lagrangian). Overlap 0: every cell lives on exactly one rank; nodes on rank borders are shared, one rank
/// owns each. Nodes are the vertices and, in a mesh of second order, the middles of edges, faces and cells
/// (NodeMap); numbered 0..node_count-1 locally, owned or ghost.
namespace impact {

/// Cells of one shape on this rank. connectivity[cell * nodes + a] = local node, usual finite-element order
/// (counter-clockwise, VTK), positive Jacobian checked at construction.
struct CellTable {
  Shape shape;
  std::vector<int> connectivity;
  std::vector<PetscInt> point; ///< DMPlex point of each cell
};

/// Boundary facets of a named group on this rank, each owned by the rank of its cell.
/// Node order gives the outward normal of the cell: in 2D (t_y, -t_x) with t = x_1 - x_0, in 3D (x_1-x_0) x
/// (x_2-x_0); of second order the corners come first, then the middles of the edges, then that of the facet.
struct FacetTable {
  int nodes_per_facet = 0;          ///< 2 (edges), 3 or 4, of second order 3, 6, 8 or 9; triangles in a mixed
                                    ///< 3D table repeat the last node
  std::vector<int> connectivity;    ///< [facet][nodes_per_facet] local nodes
  std::vector<PetscInt> point;      ///< DMPlex point of each facet
  std::vector<PetscInt> cell_point; ///< DMPlex point of the cell behind it
  int count() const { return static_cast<int>(point.size()); }
  /// Those to whose number `leave` says no.
  template <class Leave> FacetTable without(Leave&& leave) const {
    FacetTable rest{nodes_per_facet, {}, {}, {}};
    const auto corners = static_cast<std::size_t>(nodes_per_facet);
    for (std::size_t f = 0; f < point.size(); ++f) {
      if (leave(f)) continue;
      rest.point.push_back(point[f]);
      rest.cell_point.push_back(cell_point[f]);
      for (std::size_t a = 0; a < corners; ++a) rest.connectivity.push_back(connectivity[corners * f + a]);
    }
    return rest;
  }
};

/// One physical group of the mesh file.
struct Group {
  std::string name;
  int dim = 0; ///< dim of the mesh: a region; dim - 1: a boundary; 0: points
};

/// More members and functions than elsewhere: every room asks the mesh, and each answer is one of its own.
class Mesh {
public:
  /// Takes a distributed, interpolated DMPlex (overlap 0) with one label per physical group name. A rank may
  /// hold no cell at all. Collective. Throws UserError(data) for unsupported cells, inverted or degenerate
  /// cells (named by region and coordinates).
  /// `patches`: [cell] of this rank, cell_patches.hpp; none where there are none.
  Mesh(Handle<DM> dm, std::vector<Group> groups, std::vector<PetscInt> patches = {});

  DM dm() const { return dm_; }
  MPI_Comm comm() const;
  int dim() const { return dim_; }
  int order() const { return order_; }              ///< of the cells: 1 or 2
  int node_count() const { return nodes_.count(); } ///< local, ghosts included
  int owned_node_count() const { return owned_node_count_; }
  PetscInt global_node_count() const { return global_node_count_; }
  PetscInt global_cell_count() const { return global_cell_count_; }
  std::span<const double> coordinates() const { return coordinates_; } ///< [node][dim]
  std::span<const CellTable> cells() const { return cells_; }
  /// Global number of each local node: owned nodes are contiguous on a rank, in the order of PETSc's global
  /// vectors.
  std::span<const PetscInt> global_node() const { return global_node_; }
  bool owned(int node) const {
    const PetscInt place = global_node_[static_cast<std::size_t>(node)] - first_node_;
    return place >= 0 && place < owned_node_count_;
  }
  PetscInt point(int node) const { return nodes_.point(node); } ///< of the DMPlex
  PetscInt cell_start() const { return cell_start_; }           ///< first DMPlex cell point
  int cell_count() const { return cell_count_; }                ///< on this rank, all shapes
  bool has_shape(Shape shape) const;                            ///< on any rank
  /// The patch of each cell, [cell point minus cell_start], all on this rank; -1: none. Empty without any.
  const std::vector<PetscInt>& patches() const { return patches_; }

  const std::vector<Group>& groups() const { return groups_; }
  const Group* find_group(const std::string& name) const;
  /// The group, or UserError(data) that lists the groups there are. Same on all ranks, not collective.
  const Group& group(const std::string& name) const;
  /// DMPlex points of the cells of a region (dim-dimensional group) on this rank. Throws UserError(data)
  /// alike on all ranks when there is no such group or it is no region; so do facets (no boundary) and nodes.
  std::vector<PetscInt> region_cells(const std::string& name) const;
  /// Facets of a boundary group on this rank. A facet inside a body takes one of its two cells.
  FacetTable facets(const std::string& name) const;
  /// All facets on the outside of bodies, faces of slits among them. Collective.
  FacetTable outer_facets() const;
  /// Those facets of a boundary whose cell is there, then the facets inside the bodies of the boundary where
  /// one of two cells is. `eroded`: [cell point minus cell_start] 1 for cells that are not; `body`: [local
  /// node] 1 for the nodes of those bodies. Collective.
  FacetTable live_facets(const std::string& name, const std::vector<char>& eroded,
                         const std::vector<char>& body) const;
  /// Refuses a boundary group some of whose facets lie inside a body, where what acts would have two sides to
  /// choose from: UserError(data) that begins with `option` and the group. Collective.
  void require_outside(const std::string& option, const std::string& name) const;
  /// Sorted local nodes of a boundary, region or point group, complete on every rank (also where a rank holds
  /// only the node and no facet or cell of the group). Collective.
  std::vector<int> nodes(const std::string& name) const;
  /// Shares of the nodes in groups of points (1 each) or of curves (half of each edge that meets there) in
  /// the reference configuration: [local node], to be summed over the ranks that hold a node.
  std::vector<double> node_shares(const std::vector<std::string>& names) const;
  /// Shortest cell edge over all ranks, computed at construction.
  double smallest_edge() const { return smallest_edge_; }
  /// For messages: names of the regions that hold a cell point, separated by commas; a node's place, "(x,
  /// y)".
  std::string regions_of(PetscInt cell_point) const;
  std::string place(int node) const;

private:
  FacetTable no_facets() const;
  std::vector<int> cells_beside() const;
  void read_coordinates();
  void number_nodes();
  void read_cells();
  void check_cells() const;
  void measure_edges();
  struct CellNodes {
    Shape shape; // none where a cell of that kind cannot be used
    std::vector<int> node;
  };
  CellNodes cell_nodes(PetscInt cell) const;
  std::vector<int> closure(PetscInt point) const; // its nodes in the order of DMPlex
  void add_facet(PetscInt facet, PetscInt cell, FacetTable& table) const;
  std::vector<PetscInt> points(const std::string& group) const;
  std::vector<PetscInt> owned_points(const std::string& group) const;

  Handle<DM> dm_;
  int dim_ = 0, order_ = 1, owned_node_count_ = 0, cell_count_ = 0;
  NodeMap nodes_;
  PetscInt cell_start_ = 0, first_node_ = 0, global_node_count_ = 0, global_cell_count_ = 0;
  std::vector<double> coordinates_;
  std::vector<CellTable> cells_;
  std::vector<int> has_shape_; // [known shape] 1 or 0, equal on all ranks
  std::vector<PetscInt> global_node_;
  std::vector<Group> groups_;
  std::vector<PetscInt> patches_;
  double smallest_edge_ = 0;
};

/// The same mesh on the same ranks with other reference coordinates; `shift`: [local node][dim], equal on all
/// ranks that share a node. The coordinates of the mesh's DM change with it, so that the old mesh is of no
/// more use. Throws UserError(data) where a cell is turned inside out. Collective.
Mesh shifted_mesh(const Mesh& mesh, const std::vector<double>& shift);

/// The points with a value in a label, sorted; none where there is no such label.
std::vector<PetscInt> labelled_points(DM dm, const std::string& label, PetscInt value);

/// Values at the points of a DMPlex, [point]: all ranks that share a point get what `op` makes of theirs.
/// Collective.
void share_points(DM dm, MPI_Op op, std::vector<int>& value);

/// Bodies: the sets of nodes that cells join, on any ranks.
struct Bodies {
  std::vector<int> of_node; ///< [local node]; -1 where a node does not count
  int count = 0;            ///< over all ranks; a body's number is the same on all of them
};

/// The bodies of a mesh, or of its nodes that count ([local node], alike on the ranks that share one), by
/// rising number of their lowest node, which depends on the partition. Collective.
Bodies find_bodies(const Mesh& mesh, const std::vector<char>& counts = {});

/// [local node] 1 in the bodies that hold these local nodes, complete on every rank. Collective.
std::vector<char> nodes_of_bodies(const Mesh& mesh, const std::vector<int>& nodes);

/// Cost of cells, for the partition. The type `metis` gives ranks equal shares of cells and, besides, of what
/// the boundaries cost; other types know the sum.
struct PartitionWeights {
  std::map<std::string, int> region; ///< cost of a cell by region name; absent = 1
  std::map<std::string, int>
      boundary; ///< extra cost of a cell per facet on these boundaries (contact surfaces)
};

/// A triangle or tetrahedron, a region of its own, that shares no node with anything.
struct AddedCell {
  std::string region;
  std::vector<std::array<double, 3>> corner; ///< 3 counter-clockwise, or 4 of positive volume
};

struct GmshFile;

/// How a mesh is made from a file.
struct MeshRequest {
  std::string file; ///< .msh 4.1 (or 2.2 without overlapping groups) or .geo
  std::map<std::string, std::string>
      parameters;                              ///< -mesh_set_<name>: values of DefineConstant names in a .geo
  int order = 0;                               ///< of the cells, 1 or 2; 0: that of the file, 1 for a .geo
  Middles middles = Middles::all;              ///< that order 2 gives to a file of first order
  double scale = 1;                            ///< every coordinate is multiplied by it
  int refine = 0;                              ///< uniform refinements
  double most_cells = 2e6;                     ///< refinement to more is refused before it is made
  double patience = 600;                       ///< seconds after which gmsh is stopped; 0: never
  std::string work_dir = ".";                  ///< where a .geo's mesh is written
  std::function<std::string()> reason_to_stop; ///< asked for on rank 0 while gmsh works; "": none
  /// Cells beside those of the file, asked for once its dimension and the box around its nodes (smallest x,
  /// y, z, then largest) are known; alike on all ranks. Empty: none.
  std::function<std::vector<AddedCell>(int dim, const std::array<double, 6>& box)> add;
  PartitionWeights weights;
  std::vector<std::vector<std::string>> patched; ///< the regions of each material with patches
};

/// Reads (or makes with gmsh, run as a program on rank 0, never through a shell), checks, distributes and
/// orders the mesh. Clockwise cells are turned. Groups without a name are called region_<tag>,
/// boundary_<tag>, curve_<tag>, point_<tag>. Collective. Partitioner: own type `metis` unless
/// -petscpartitioner_type says otherwise. Throws UserError(io) for a file that cannot be read, made or
/// understood and UserError(data) for a mesh that cannot be used: no groups, mixed dimensions or orders,
/// duplicated, folded, inverted or degenerate cells, loose nodes.
Mesh read_mesh(MPI_Comm comm, const MeshRequest& request);
/// Its two halves: what the file says, each rank an equal part; and the mesh made of that, the same from the
/// same parts wherever they were kept.
GmshFile read_mesh_file(MPI_Comm comm, const MeshRequest& request);
Mesh build_mesh(MPI_Comm comm, const MeshRequest& request, GmshFile file);
/// Throws UserError(usage) for what a request asks of no file of its kind. No communication.
void check_request(const MeshRequest& request);

/// Moves the cells of a mesh to the ranks (overlap 0) by weight, wherever they are; `dm` is replaced. Cells
/// of one patch, [cell], come to one rank, and `patches` goes with them. Returns the migration SF, empty when
/// nothing moved (one rank). Throws UserError(usage) for patches with another partitioner than ours.
/// Collective.
Handle<PetscSF> distribute(Handle<DM>& dm, const PartitionWeights& weights, std::vector<PetscInt>& patches);

/// Whether each rank has its share of the cells, and of the facets of the weights' boundaries, as far as
/// whole cells and facets allow. Collective.
bool evenly_shared(DM dm, const PartitionWeights& weights);

/// Renumbers the points of each rank so that neighbours stand close in memory (reverse Cuthill-McKee).
/// `patches` goes with its cells. Collective.
void order_for_locality(Handle<DM>& dm, std::vector<PetscInt>& patches);

} // namespace impact
