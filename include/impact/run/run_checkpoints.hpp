#pragma once
#include <impact/run/snapshot.hpp>
#include <impact/run/stage.hpp>
#include <impact/run/stop_criteria.hpp>
#include <impact/time/step_control.hpp>

/// The checkpoints of one run: where it resumes from, when it writes one, what goes in beside the table.
namespace impact {

/// The checkpoint to go on from as -restart says, its options checked against those of this run. Collective.
/// Throws UserError.
std::optional<Checkpoint> find_checkpoint(MPI_Comm comm, const Scenario& scenario);

/// Takes the checkpoints of an earlier run out of use, so that nobody takes them for those of this one.
/// Collective.
void retire_older_runs(MPI_Comm comm, const Scenario& scenario, const std::optional<Checkpoint>& resume);

class RunCheckpoints {
public:
  /// Adds the row of the step control to the table. The stage must outlive it.
  explicit RunCheckpoints(RunStage& stage);

  /// Goes on as the checkpoint has it, once the state is read. Collective.
  void resume(const Checkpoint& from, StopCriteria& stops);
  /// Whether steps or the clock, in seconds since the start, ask for one.
  bool due(long step, double wall) const;
  /// Writes one; returns the seconds that it took. Collective. Throws UserError(io).
  double write(const Snapshot& at, const StepControlState& control, const StopCriteria& stops, double wall);
  /// Step of the last one, -1 without.
  long step() const { return step_; }
  const std::string& file() const { return file_; }

private:
  RunStage& stage_;
  StateRow& control_; ///< dt, whether it is at its limit, easy steps, rejections
  CheckpointWriter writer_;
  std::string file_;
  long step_ = -1;
  double wall_ = 0;
};

} // namespace impact
