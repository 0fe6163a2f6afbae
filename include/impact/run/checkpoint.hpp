#pragma once
#include <impact/mesh/cell_batches.hpp>
#include <impact/mesh/state_table.hpp>
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
/// with the same bits, and so do they on others.
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
};

struct CheckpointFolder {
  std::string dir; ///< made when missing
  int keep = 2;    ///< newest ones that stay, at least 1
};

/// A checkpoint whose checksum was found right.
struct Checkpoint {
  std::string file;
  CheckpointValues values;
  std::vector<std::string> warnings; ///< newer ones that were damaged: file and reason
};

/// Writes the committed halves of all rows with checkpointed == true and removes what is older than the
/// newest `folder.keep`. Returns the file name. Collective. Throws UserError(io) on all ranks; checkpoints
/// that were there before stay valid.
std::string write_checkpoint(const CheckpointState& state, const CheckpointValues& values,
                             const CheckpointFolder& folder);

/// The newest undamaged checkpoint of a directory; empty when it holds none at all. Collective. Throws
/// UserError(io) when there are some and all are damaged: a run never starts anew unasked.
std::optional<Checkpoint> newest_checkpoint(MPI_Comm comm, const std::string& dir);

/// The checkpoint of that name. Collective. Throws UserError(io) when it is missing or damaged.
Checkpoint open_checkpoint(MPI_Comm comm, const std::string& file);

/// Fills committed and trial halves of all rows with checkpointed == true. The table must have the rows of
/// the run that wrote. Collective. Throws UserError(io): another mesh, other rows, unreadable.
void read_checkpoint(const Checkpoint& checkpoint, CheckpointState state);

/// The mesh that a checkpoint holds, distributed over the ranks at hand by weight. Collective. Throws
/// UserError(io).
Mesh read_checkpoint_mesh(MPI_Comm comm, const Checkpoint& checkpoint, const PartitionWeights& weights = {});

} // namespace impact
