#pragma once
#include <impact/scenario/scenario.hpp>

/// The folder that a run writes to: one run at a time, and what an earlier one left there is kept.
namespace impact {

/// Holds a folder for this run. The lock is the system's (flock on <folder>/.impact.lock): it ends with the
/// process, however that ends. File systems without such locks (some NFS, Lustre) give none.
class FolderLock {
public:
  /// Makes the folder, which `option` named. Collective. Throws UserError(io) naming the run that holds it.
  FolderLock(MPI_Comm comm, const std::string& option, const std::string& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

private:
  std::string file_;
  int descriptor_ = -1; // on rank 0
};

/// Moves what a run of this scenario would overwrite (history, fields, checkpoints in their usual place) to
/// <output_dir>/earlier_<n>, where an earlier run had taken steps. `resumed`: the checkpoint to go on from;
/// nothing moves when it is one of this folder. Says so. Collective.
void set_earlier_run_aside(MPI_Comm comm, const Scenario& scenario,
                           const std::optional<std::string>& resumed);

} // namespace impact
