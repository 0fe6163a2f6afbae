#pragma once
#include <impact/input/condition.hpp>
#include <impact/io/checkpoint.hpp>
#include <impact/io/history_file.hpp>
#include <impact/scenario/scenario.hpp>

/// What ends a run from inside: conditions on the columns of its history (`-stop_<id>_when`), with the
/// largest values that peak() asks for. Rank 0 decides, because its rows are those of the history. Peaks go
/// into checkpoints by the text of what they are the peak of, beside the options, so that a restart finds
/// them on any number of ranks and may drop and add criteria.
namespace impact {

class StopCriteria {
public:
  /// Not collective.
  StopCriteria(MPI_Comm comm, const Scenario& scenario);

  /// Throws UserError(usage) when a criterion names what is no column of `row`. The same on all ranks.
  void check_names(const HistoryFile::Row& row) const;
  /// Takes note of a row; returns the option and text of the first criterion that holds, empty when none
  /// does. Collective.
  std::string ask(const HistoryFile::Row& row);

  void store(CheckpointValues& values) const;
  /// Peaks that the checkpoint does not hold begin at the restart; their texts are returned.
  std::vector<std::string> restore(const CheckpointValues& values);

private:
  MPI_Comm comm_;
  mutable std::vector<Condition> criteria_;
};

} // namespace impact
