#pragma once
#include <impact/balance/ledger.hpp>
#include <impact/run/field_source.hpp>
#include <impact/run/snapshot.hpp>
#include <impact/scenario/scenario.hpp>

/// The history file: step, balances, contacts, rigid bodies, cracks, probes and measures.
namespace impact {

/// Name of the history file below -output_dir: that of the first csv output, else history.csv.
std::string history_file_name(const Scenario& scenario);

/// Columns for the components of a vector from `first` on.
void add_axes(HistoryFile::Row& row, const std::string& name, const double* values, std::size_t end,
              std::size_t first = 0);

// Members beyond twelve: what each kind of column reads, and when rows are due.
class HistoryObserver {
public:
  static constexpr int numbers_of_crack = 9;

  /// Throws UserError for fields that the run does not offer and probes outside of its bodies. Collective.
  HistoryObserver(const Scenario& scenario, MotionProblem& motion, const Ledger& ledger, StateTable& state,
                  const FieldSource& source);
  /// Starts the file, or continues it after a step; it must have these columns then. Collective, once.
  void open(std::optional<long> resume_after, const HistoryFile::Row& columns);
  /// The row of a state, written or not. Collective.
  HistoryFile::Row row(const Snapshot& snapshot, const StepCounts& counts);
  /// Whether the step of length dt that ends at t has a row.
  bool due(long step, double t, double dt) const;
  /// Writes the row where it is due, and returns it. Collective.
  HistoryFile::Row watch(const Snapshot& snapshot, const StepCounts& counts);
  /// Writes the row of the last state too, where it was not due. Collective.
  void finish();
  /// Whether every step has a row.
  bool every_step() const { return cycles_ == 0 && dt_ == 0 && every_ == 1; }
  /// Step of the last row that a resumed file kept, -1 without one. On all ranks.
  long last_step() const { return file_->last_step(); }

private:
  void append_contacts(HistoryFile::Row& row, const Snapshot& snapshot) const;
  void append_rigid_bodies(HistoryFile::Row& row, const Snapshot& snapshot) const;
  void append_cracks(HistoryFile::Row& row, double time);
  void append_probes(HistoryFile::Row& row, const Snapshot& snapshot) const;
  void append_measures(HistoryFile::Row& row, const Snapshot& snapshot) const;
  void append_releases(HistoryFile::Row& row, const Snapshot& snapshot);
  void locate_probes();
  void find_shares();
  void find_ways();

  struct Located {
    int nodes[max_nodes];
    double N[max_nodes];
    int count = 0;         ///< 0 on ranks that do not hold the probe's cell
    std::size_t batch = 0; ///< of all groups' batches, and the lane: where cell fields have the cell
    std::size_t lane = 0;
  };
  // What a value of a group counts in its mean: of an owned node, or of a cell by its volume.
  struct Share {
    std::size_t row, lane; ///< in a field [row][component][lane]: node; or batch, and lane there
    double weight;
  };
  const Scenario& scenario_;
  MotionProblem& motion_;
  const Ledger& ledger_;
  const BodyRows bodies_;
  const StateRow &v_, &a_;
  const StateRow *phi_, *load_;
  const FieldSource& source_;
  std::optional<HistoryFile> file_;
  // Of the csv output; without one a row for each step, or for a thousandth of an explicit run.
  int cycles_ = 0, every_ = 1; ///< of -ts_period between rows, 0: not by them; steps, 0: not by them
  double dt_ = 0;              ///< 0: not by time
  std::vector<double> times_;
  HistoryFile::Row not_written_; ///< the last row, if it was not due
  std::vector<Located> probes_;
  std::vector<std::array<std::vector<Share>, 2>> shares_; ///< of each measure: nodes, cells of a region
  std::vector<std::vector<double>> ways_; ///< of each release, what nodes advance by, local [node][dim]
  std::vector<double> phi_before_;        ///< [local node] of the row before
  struct CracksOf {
    std::size_t material;
    std::vector<int> nodes; ///< local
    StateRow& kept;         ///< of each crack numbers_of_crack, see history_cracks.cpp
  };
  std::vector<CracksOf> cracks_; ///< of each material with damage
};

} // namespace impact
