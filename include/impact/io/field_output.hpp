#pragma once
#include <impact/mesh/cell_batches.hpp>
#include <limits>
#include <memory>
#include <optional>

/// Fields over time as <path>.xdmf (which ParaView opens) and a folder <path>.fields: the mesh once, in
/// reference coordinates, and a file for each written time. Every file is written under another name, through
/// to the disk, and then renamed, the .xdmf last: a run can be looked at while it goes on, and a kill or a
/// full disk costs at most the time that is being written. Vectors of plane problems get a third component 0.
///
/// mesh_<m>.h5: /geometry [node][3], /topology, /region [cell], /regions, /checksum; nodes in the mesh's
/// global numbering, which another number of ranks changes. <k>.h5, in six digits: /node/<name> and
/// /cell/<name> [entity][component], /mesh (the checksum of the mesh they belong to), /time.
/// options/README.md describes them for readers.
namespace impact {

struct Field {
  std::string name;
  bool on_nodes;
  int components;
  /// [local node][component], of which ghosts are ignored; or [cell][component], cells in the order of the
  /// tables in mesh.cells().
  std::span<const double> values;
};

struct FieldFile {
  std::string path;         ///< with or without .xdmf; missing directories are made
  std::string title, units; ///< kept in the .xdmf
  /// Continue existing files after this time: later times are dropped. Empty: start anew, removing old files.
  std::optional<double> resume_after = std::nullopt;
  std::vector<std::int64_t> region =
      {};                   ///< number of each cell's region, in the order of a cell field; or none
  std::string regions = {}; ///< their names, a line of number, region, material each
};

class FieldSeries;
struct FieldMesh;

class FieldOutput {
public:
  /// Writes the mesh (unless a resumed output has it already), which must outlive this. Collective. Throws
  /// UserError(io) on all ranks.
  FieldOutput(const Mesh& mesh, const FieldFile& file);
  FieldOutput(FieldOutput&&) noexcept;
  FieldOutput& operator=(FieldOutput&&) noexcept;
  ~FieldOutput();

  /// Adds one time; a time that is there already is replaced. The same fields, in the same order, on all
  /// ranks. Collective. Throws UserError(io) on all ranks; the times written before stay readable.
  void write(double time, const std::vector<Field>& fields);

  /// The last time in the files, -infinity without one; equal on all ranks.
  double last_time() const { return last_time_; }

  /// Tells the user what happened to the files that were resumed (empty: nothing), equal on all ranks.
  const std::string& warning() const { return warning_; }

private:
  void write_mesh(const FieldMesh& stored, const FieldFile& request);

  const Mesh* mesh_;
  std::unique_ptr<FieldSeries> series_; // on rank 0 of use
  std::string warning_;
  double last_time_ = -std::numeric_limits<double>::infinity();
};

/// Brings values of cell groups, [group][batch][component][lane], into the cell order of a cell field.
std::vector<double> cells_in_mesh_order(const Mesh& mesh, const std::vector<CellGroup>& groups,
                                        int components, std::span<const double> by_batch);

} // namespace impact
