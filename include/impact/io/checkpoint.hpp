#pragma once
#include <impact/mesh/cell_batches.hpp>
#include <impact/mesh/gmsh.hpp>
#include <impact/mesh/state_table.hpp>
#include <optional>

/// Checkpoints: the state of a run in numbered files <dir>/checkpoint_000007.h5, each beside a small manifest
/// that is written last, holds size and checksum, and with them what the run wants to find again. A file
/// without its manifest does not count, so a kill at any instant leaves the one before it as the newest.
///
/// The HDF5 file holds each row of the state table as /state/<row> [entity][double], the keys of the entities
/// (vertices, cells, facets of a surface) as /keys/<set> [entity][2], both in the order of the ranks that
/// wrote, and the mesh as its file had it as /mesh. Keys are made of coordinates and regions alone: the state
/// can be read onto any mesh that has the same cells, on any number of ranks, and every double returns with
/// the same bits. A restart builds its mesh from /mesh, so that numbers and parts are those of a run that
/// read the file.
namespace impact {

/// A run wants to find these again beside the state table.
struct CheckpointValues {
  double time = 0;
  long step = 0;
  std::map<std::string, std::string> texts; ///< e.g. the resolved options
};

/// The state that goes into and comes out of a checkpoint.
struct CheckpointState {
  const Mesh& mesh;
  const std::vector<CellGroup>& groups;
  StateTable& table;
  const GmshFile* file = nullptr; ///< the mesh file, of each rank its part: with it a restart needs no other
};

struct CheckpointFolder {
  std::string dir; ///< made when missing
  int keep = 2;    ///< newest ones that stay, at least 1
  /// Seconds, beside one per megabyte, after which a write that does not end is given up with exit status 4.
  double patience = 60;
};

/// A checkpoint whose checksum was found right.
struct Checkpoint {
  std::string file;
  CheckpointValues values;
  std::string rows;                  ///< the rows of the state table: a line each
  std::vector<std::string> warnings; ///< newer ones that were damaged: file and reason
};

struct Entities;

/// Writes the checkpoints of a run on one mesh, all of whose rows are in the table at the first one.
class CheckpointWriter {
public:
  /// The objects that `state` refers to must outlive the writer.
  CheckpointWriter(const CheckpointState& state, CheckpointFolder folder);
  ~CheckpointWriter();
  CheckpointWriter(const CheckpointWriter&) = delete;
  CheckpointWriter& operator=(const CheckpointWriter&) = delete;

  /// Writes the committed halves of all rows with checkpointed == true and removes what is older than the
  /// newest `folder.keep`. Returns the file name. Collective. Throws UserError(io) on all ranks; checkpoints
  /// that were there before stay valid.
  std::string write(const CheckpointValues& values);

private:
  CheckpointState state_;
  CheckpointFolder folder_;
  std::vector<Entities> entities_; // found by the first write
};

/// The newest undamaged checkpoint of a directory; empty when it holds none at all. Collective. Throws
/// UserError(io) when there are some and all are damaged: a run never starts anew unasked.
std::optional<Checkpoint> newest_checkpoint(MPI_Comm comm, const std::string& dir);

/// The checkpoint of that name. Collective. Throws UserError(io) when it is missing or damaged.
Checkpoint open_checkpoint(MPI_Comm comm, const std::string& file);

/// Takes the checkpoints of a directory out of use, or those newer than `resumed` when it is one of them: a
/// run that starts over must not be continued from what an earlier one left. Their manifests are renamed to
/// .manifest.old; the files go when newer checkpoints follow. Returns how many there were. Collective. Throws
/// UserError(io).
int retire_checkpoints(MPI_Comm comm, const std::string& dir, const std::string& resumed = {});

/// Rows by which a run may differ from the one that wrote: those that a checkpoint may lack, which then stay
/// as they are, and those that it may have in vain.
struct OtherRows {
  std::vector<std::string> lacking, in_vain;
};

/// Fills committed and trial halves of all rows with checkpointed == true. The table must have the rows of
/// the run that wrote but for `others`. Collective. Throws UserError(io): another mesh, other rows,
/// unreadable.
void read_checkpoint(const Checkpoint& checkpoint, CheckpointState state, const OtherRows& others = {});

/// The file of the mesh as the run that wrote the checkpoint read it, of each rank a part; none where the
/// checkpoint has none. Collective. Throws UserError(io).
std::optional<GmshFile> read_checkpoint_mesh_file(MPI_Comm comm, const Checkpoint& checkpoint);

} // namespace impact
