#pragma once
#include <cstdint>
#include <string>
#include <vector>

/// The files of one field output, <path>.xdmf and those in <path>.fields: which are there, which count. On
/// rank 0.
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

/// The XDMF 3 description of fields over time that are stored in HDF5 files, which it names relative to
/// itself.
struct XdmfFile {
  std::string title, units;
  std::vector<XdmfMesh> meshes;
  std::vector<XdmfFrame> frames;

  /// The whole document: one temporal collection, a grid with its Time per frame.
  std::string text() const;
};

class FieldSeries {
public:
  explicit FieldSeries(std::string path) : path_(std::move(path)) {}

  std::string xdmf_file() const { return path_ + ".xdmf"; }
  std::string folder() const { return path_ + ".fields"; }
  std::string file(const std::string& name) const { return folder() + "/" + name; }
  /// As the .xdmf names it.
  std::string relative(const std::string& name) const;

  /// Takes up the meshes that are there; true when that of this checksum is among them. What cannot be used
  /// is renamed and told in `warning`.
  bool find_meshes(const std::string& sum, std::string& warning);
  /// Takes the times up to `after` into the list.
  void find_frames(double after, std::string& warning);
  /// Of the files that may be ours, those stay that the .xdmf names, the mesh of this run, and what was set
  /// aside.
  void remove_all_but_named() const;

  std::string next_mesh_name() const;
  /// The file of a time: that which has it already, or a new one.
  std::string frame_name(double time) const;
  void add_mesh(const XdmfMesh& entry, const std::string& sum);
  /// Adds or replaces a time and writes the .xdmf.
  void add_frame(const XdmfFrame& frame);
  void replace_xdmf() const;

  XdmfFile xdmf;
  std::size_t mesh = 0; ///< into xdmf.meshes: the one of this run
  const std::string& mesh_sum() const { return sums_[mesh]; }

private:
  XdmfFrame read_frame(const std::string& name) const;
  void set_aside(const std::string& name, const std::exception& error, std::string& warning) const;

  std::string path_;              // without extension
  std::vector<std::string> sums_; // of xdmf.meshes
  int next_mesh_ = 0, next_frame_ = 0;
};

} // namespace impact
