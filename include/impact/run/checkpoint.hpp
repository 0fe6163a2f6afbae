#pragma once
#include <impact/mesh/cell_batches.hpp>
#include <impact/mesh/gmsh.hpp>
#include <impact/mesh/state_table.hpp>
#include <impact/petsc/error.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

/// Checkpoints: the state of a run in numbered files <dir>/checkpoint_000007.h5, each beside a small manifest
/// that is written last and holds size and checksum. A file without its manifest does not count, so a kill at
/// any instant leaves the one before it as the newest.
///
/// A file holds the mesh (topology, coordinates, labels) and the rows of the state table in sections on its
/// points, all through PETSc's DMPlex calls, and the values of the run in /impact. Points are recognised by
/// `point_keys`: numbers made of the coordinates of a point's cells alone. The state can therefore be read
/// onto any mesh that has the same cells, on any number of ranks; on the same number every double returns
/// with the same bits, and so do they on others. Beside it stands the mesh as its file had it: a restart
/// builds its own from that, so that numbers and parts are those of a run that read the file.
namespace impact {

/// What a run wants to find again beside the state table.
struct CheckpointValues {
  double time = 0;
  long step = 0;
  std::map<std::string, double> numbers;
  std::map<std::string, std::string> texts; ///< e.g. the resolved options
};

/// The state that goes into and comes out of a checkpoint.
struct CheckpointState {
  const Mesh& mesh;
  const std::vector<CellGroup>& groups;
  StateTable& table;
  const GmshFile* file = nullptr; ///< of the mesh, on rank 0: with it a restart needs no other
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
  std::vector<std::string> warnings; ///< newer ones that were damaged: file and reason
};

/// A checkpoint that could not be written to its end. HDF5 and MPI's files are left in a state in which their
/// own shutdown crashes: the program has to end without it (std::_Exit).
class UnfinishedFile : public UserError {
public:
  using UserError::UserError;
};

/// Writes the committed halves of all rows with checkpointed == true and removes what is older than the
/// newest `folder.keep`. Returns the file name. Collective. Throws UserError(io) on all ranks, as
/// UnfinishedFile when the disk refused in the middle; checkpoints that were there before stay valid. When
/// one rank alone is refused, so that the others wait for it inside HDF5, the job is aborted with the
/// message and status 4.
std::string write_checkpoint(const CheckpointState& state, const CheckpointValues& values,
                             const CheckpointFolder& folder);

/// Waits until the files that write_checkpoint replaced are gone: it removes them while the run goes on.
/// Collective.
void await_removal(MPI_Comm comm);

/// The newest undamaged checkpoint of a directory; empty when it holds none at all. Collective. Throws
/// UserError(io) when there are some and all are damaged: a run never starts anew unasked.
std::optional<Checkpoint> newest_checkpoint(MPI_Comm comm, const std::string& dir);

/// Takes the checkpoints of a directory out of use, or those newer than `resumed` when it is one of them: a
/// run that starts over must not be continued from what an earlier one left. Their manifests are renamed to
/// .manifest.old; the files go when newer checkpoints follow. Returns how many there were. Collective. Throws
/// UserError(io).
int retire_checkpoints(MPI_Comm comm, const std::string& dir, const std::string& resumed = {});

/// The checkpoint of that name. Collective. Throws UserError(io) when it is missing or damaged.
Checkpoint open_checkpoint(MPI_Comm comm, const std::string& file);

/// Fills committed and trial halves of all rows with checkpointed == true. The table must have the rows of
/// the run that wrote. Collective. Throws UserError(io): another mesh, other rows, unreadable.
void read_checkpoint(const Checkpoint& checkpoint, CheckpointState state);

/// The file of the mesh as the run that wrote the checkpoint read it, on rank 0; on no rank one where the
/// checkpoint has none. Collective. Throws UserError(io).
std::optional<GmshFile> read_checkpoint_mesh_file(MPI_Comm comm, const Checkpoint& checkpoint);

/// The mesh that a checkpoint holds, distributed over the ranks at hand by weight. Collective. Throws
/// UserError(io).
Mesh read_checkpoint_mesh(MPI_Comm comm, const Checkpoint& checkpoint, const PartitionWeights& weights = {});

} // namespace impact
