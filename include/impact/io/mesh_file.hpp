#pragma once
#include <impact/io/hdf5_reader.hpp>
#include <impact/io/hdf5_writer.hpp>
#include <impact/mesh/gmsh.hpp>
#include <optional>

/// Meshes in HDF5 files, of which each rank writes and reads a part: in checkpoints, and in files of their
/// own as -mesh_convert writes them. /mesh/about is text (the version, then the head of the mesh),
/// /mesh/nodes [node][3], /mesh/cells and /mesh/boundary are the rows of ElementRows: the mesh as its file
/// had it, checked, before it is scaled, refined, distributed and ordered.
namespace impact {

/// What of a mesh goes into a file. `mesh` must outlive it. Collective.
class StoredMesh {
public:
  StoredMesh(MPI_Comm comm, const GmshFile& mesh);
  std::vector<hdf5::DataSet> data_sets() const; ///< these refer to this object

private:
  MPI_Comm comm_;
  const GmshFile& mesh_;
  std::string about_;
  ElementRows rows_;
  hdf5::Slab nodes_, cells_, boundary_;
};

/// Writes a file that holds nothing else. Returns its cells. Collective. Throws UserError(io).
std::uint64_t write_mesh_file(MPI_Comm comm, const std::string& name, const GmshFile& mesh);

/// Reads equal parts of what is stored in a file. Collective. Throws UserError(io) for a file that cannot be
/// read, holds no mesh of ours or one of another version.
GmshFile read_stored_mesh(MPI_Comm comm, const std::string& name);

} // namespace impact
