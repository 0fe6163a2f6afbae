#pragma once
#include <impact/mesh/cell_batches.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

/// Fields over time as <path>.xdmf + <path>.h5 (ParaView opens the first): the mesh once, in reference
/// coordinates, then one grid per written time. The .h5 is closed and the .xdmf complete after every write,
/// so a run can be looked at while it goes on and a kill leaves readable files. Vectors of plane problems get
/// a third component 0.
///
/// Layout of the .h5: /mesh/<m>/{geometry [node][3], topology}, /fields/<k>/{node,cell}/<name>
/// [entity][component] with attributes `time` and `mesh` (the m they belong to) on /fields/<k>. Nodes in the
/// mesh's global numbering.
namespace impact {

struct NodeField {
  std::string name;
  int components = 1;
  std::span<const double> values; ///< [local node][component]; ghosts are ignored
};

struct CellField {
  std::string name;
  int components = 1;
  std::span<const double> values; ///< [cell][component], cells in the order of the tables in mesh.cells()
};

struct FieldFile {
  std::string path;         ///< with or without .xdmf; missing directories are made
  std::string title, units; ///< kept in the .xdmf
  /// Continue an existing file after this time: later times are dropped. Empty: start anew, replacing old
  /// files.
  std::optional<double> resume_after = std::nullopt;
};

class FieldOutput {
public:
  /// Writes the mesh (unless the resumed file holds it already). Collective. Throws UserError(io) on all
  /// ranks.
  FieldOutput(const Mesh& mesh, const FieldFile& file);
  FieldOutput(FieldOutput&&) noexcept;
  FieldOutput& operator=(FieldOutput&&) noexcept;
  ~FieldOutput();

  /// Adds one time; a time that is there already is replaced. The same fields, in the same order, on all
  /// ranks. Collective. Throws UserError(io) on all ranks; the times written before stay readable.
  void write(double time, const std::vector<NodeField>& nodes, const std::vector<CellField>& cells);

  /// What the user should know about the file that was resumed (empty: nothing), equal on all ranks.
  const std::string& warning() const { return warning_; }

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  std::string warning_;
};

/// Brings values of cell groups, [group][batch][component][lane], into the cell order of CellField.
std::vector<double> cells_in_mesh_order(const Mesh& mesh, const std::vector<CellGroup>& groups,
                                        int components, std::span<const double> by_batch);

} // namespace impact
