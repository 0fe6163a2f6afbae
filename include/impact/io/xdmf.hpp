#pragma once
#include <cstdint>
#include <string>
#include <vector>

/// The XDMF 3 description of fields over time that are stored in HDF5 files. Files are named relative to the
/// .xdmf.
namespace impact {

struct XdmfMesh {
  std::string file;      ///< holds /geometry [nodes][3] and /topology
  std::string cell_type; ///< Triangle, Quadrilateral, Tetrahedron, Hexahedron or Mixed
  std::uint64_t nodes, cells;
  std::uint64_t topology_length; ///< integers in the topology
  bool regions = false;          ///< holds /region [cells]
};

struct XdmfField {
  std::string name;
  bool on_nodes;
  int components;
};

struct XdmfFrame {
  double time;
  std::string file; ///< fields lie in /node/<name> and /cell/<name>
  std::size_t mesh; ///< index into XdmfFile::meshes
  std::vector<XdmfField> fields;
};

struct XdmfFile {
  std::string title, units;
  std::vector<XdmfMesh> meshes;
  std::vector<XdmfFrame> frames;

  /// The whole document: one temporal collection, a grid with its Time per frame.
  std::string text() const;
};

} // namespace impact
