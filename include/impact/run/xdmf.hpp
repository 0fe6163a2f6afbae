#pragma once
#include <cstdint>
#include <string>
#include <vector>

/// The XDMF 3 description of fields over time that are stored in one HDF5 file.
namespace impact {

struct XdmfMesh {
  std::string group;     ///< holds geometry [nodes][3] and topology
  std::string cell_type; ///< Triangle, Quadrilateral, Tetrahedron, Hexahedron or Mixed
  std::uint64_t nodes, cells;
  std::uint64_t topology_length; ///< integers in the topology
};

struct XdmfField {
  std::string name;
  bool on_nodes;
  int components;
};

struct XdmfFrame {
  double time;
  std::string group; ///< fields lie in <group>/node/<name> and <group>/cell/<name>
  std::size_t mesh;  ///< index into XdmfFile::meshes
  std::vector<XdmfField> fields;
};

struct XdmfFile {
  std::string title, units, data_file; ///< data_file: name of the .h5, relative to the .xdmf
  std::vector<XdmfMesh> meshes;
  std::vector<XdmfFrame> frames;

  /// The whole document: one temporal collection, a grid with its Time per frame.
  std::string text() const;
};

} // namespace impact
