#pragma once
#include <cstdint>
#include <impact/mesh/mesh.hpp>
#include <impact/petsc/error.hpp>
#include <map>
#include <string>
#include <vector>

/// Mesh files of gmsh as plain arrays, checked; and gmsh itself as a program. Nothing here communicates.
namespace impact {

/// A physical group that has elements.
struct GmshGroup {
  std::string name; ///< from $PhysicalNames (blanks allowed) or region_<tag>, boundary_<tag>, curve_<tag>,
                    ///< point_<tag>
  int dim = 0, tag = 0;
};

/// Elements of one type that belong to the same groups.
struct GmshBlock {
  int dim = 0, nodes = 0; ///< nodes per element
  int set = 0;            ///< index into GmshFile::sets
  std::vector<int> node;  ///< [element][nodes]

  /// Of cells and facets. Throws UserError(data) where there is none.
  Shape shape() const;
};

/// A mesh of first or second order in VTK's order of nodes; of the elements of boundaries the corners. Each
/// rank may hold a part of it: nodes and cells are numbered through all ranks, the elements of boundaries
/// stand where their cells do.
struct GmshFile {
  int dim = 0;           ///< highest dimension of an element: 2 or 3; like groups and sets alike on all ranks
  std::vector<double> x; ///< [node][3]
  std::vector<GmshGroup> groups;
  std::vector<std::vector<int>> sets; ///< which groups elements are in together, as indices into `groups`
  std::vector<GmshBlock> blocks;
  int turned_cells = 0; ///< cells whose node order was clockwise and has been reversed
};

/// Reads version 4.1 or 2.2, ASCII or binary, and checks it: every element has known, distinct nodes; cells
/// are triangles, quadrilaterals, tetrahedra or hexahedra of the same dimension and order, at least one group
/// exists, each cell occurs once, coordinates are finite, 2D meshes are flat, each node belongs to a cell,
/// cells do not fold over their neighbours. Clockwise cells are turned. Throws UserError(io) for an
/// unreadable or garbled file, else UserError(data).
GmshFile read_gmsh(const std::string& path);

/// The checks of read_gmsh after parsing; sets `dim`, turns clockwise cells. Throws UserError(data).
void check_gmsh(GmshFile& file, bool version4);

/// The elements of a part as rows that can be cut anywhere: files and messages hold these.
struct ElementRows {
  std::size_t width = 0;           ///< 1 + the most nodes of a cell of any rank
  std::vector<std::int64_t> cells; ///< [cell][width]: set, nodes, -1 behind the last one
  std::vector<std::int64_t>
      boundary; ///< [element][1 + width]: the cell behind it, then as a cell; by rising cell
};

/// The rows of a part; boundary elements in no group are left out. Collective. Throws UserError(data) for an
/// element of a group whose nodes belong to no cell together.
ElementRows rows_of(MPI_Comm comm, const GmshFile& file);
/// And back. Throws UserError(data) where the rows speak of sets or nodes that are not there.
void set_rows(GmshFile& file, const ElementRows& rows, std::int64_t node_count);
/// What is alike on all ranks, as text, a line each; and back. Throws UserError(data).
std::string head_of(const GmshFile& file);
void set_head(GmshFile& file, const std::string& head);
/// From a file that rank 0 read to equal parts on all ranks. Collective.
void spread(MPI_Comm comm, GmshFile& file);
/// Where the part of a rank in `all` things begins; that of the rank behind the last one is `all`.
inline std::int64_t part_begin(std::int64_t all, int rank, int ranks) { return all * rank / ranks; }

/// Runs `gmsh` (found on PATH, no shell) on a .geo with `-setnumber`/`-setstring` for each parameter and
/// writes `work_dir`/<stem>.msh in version 4.1; returns its path. Throws UserError(io) quoting gmsh's first
/// error line or saying why it was ended (request.reason_to_stop), UserError(data) after request.patience,
/// and UserError(usage) for a parameter whose name does not occur in the .geo.
std::string run_gmsh(const MeshRequest& request);

} // namespace impact
