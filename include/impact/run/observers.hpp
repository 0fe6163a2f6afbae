#pragma once
#include <impact/balance/ledger.hpp>
#include <impact/io/field_output.hpp>
#include <impact/io/history_file.hpp>
#include <impact/scenario/scenario.hpp>
#include <impact/solve/step_record.hpp>
#include <optional>
#include <vector>

/// Watchers of accepted steps: field files, the history file, probes and measures. Reads committed state
/// only.
namespace impact {

/// An accepted state. Committed halves of the table hold it already.
struct Snapshot {
  long step = 0;
  double time = 0, dt = 0;
  int tries = 1;
  Vec u = nullptr;
};

/// Fields by name: nodal ones from the state table, cell ones from the law, contact ones from the interfaces.
class FieldSource {
public:
  FieldSource(MotionProblem& motion, const StateTable& state) : motion_(motion), state_(state) {}
  /// Names that this run can give. A field is nodal when is_nodal(name).
  std::vector<std::string> names() const;
  static bool is_nodal(const std::string& name);
  /// Throws UserError(usage) for a field that an option asks for and the run cannot give.
  void require(const std::string& key, const std::string& name, bool nodal_only = false) const;
  /// [local node][components] for nodal names. Collective.
  std::vector<double> nodal(const std::string& name, const Snapshot& snapshot, int& components) const;
  /// [group][batch][component][lane] for cell names. Collective.
  std::vector<double> cellwise(const std::string& name, const Snapshot& snapshot, int& components) const;

private:
  std::vector<double> fatigue_means() const;

  MotionProblem& motion_;
  const StateTable& state_;
};

class FieldObserver {
public:
  /// Throws UserError(usage) when a field is not offered by this run.
  FieldObserver(const OutputScenario& output, const Scenario& scenario, const Discretisation& discretisation,
                const FieldSource& source);
  /// Starts the files, removing older ones, or continues them after a time. Collective, once.
  void open(std::optional<double> resume_after);
  /// Writes when the output's times, interval or count of steps say so, and at the end. Collective.
  void watch(const Snapshot& snapshot, bool last);

private:
  const Scenario& scenario_;
  OutputScenario settings_;
  const Discretisation& d_;
  const FieldSource& source_;
  std::optional<FieldOutput> file_;
  double next_time_ = 0;
};

/// Whether `time` is the start, or the middle or the end of a period number n, 2 n, ..
bool marks_cycle(double time, double period, int every);

/// Name of the history file below -output_dir: that of the first csv output, else history.csv.
std::string history_file_name(const Scenario& scenario);
/// Name of the .xdmf of an output below -output_dir.
std::string field_file_name(const OutputScenario& output);

class HistoryObserver {
public:
  /// Throws UserError for fields that the run does not offer and probes outside of its bodies. Collective.
  HistoryObserver(const Scenario& scenario, MotionProblem& motion, const Ledger& ledger, StateTable& state,
                  const FieldSource& source);
  /// Starts the file, or continues it after a step. Collective, once.
  void open(std::optional<long> resume_after);
  /// The row of a state, written or not. Collective.
  HistoryFile::Row row(const Snapshot& snapshot, const StepCounts& counts);
  /// Writes the row, in the cycles that the history is kept of, and returns it. Collective.
  HistoryFile::Row watch(const Snapshot& snapshot, const StepCounts& counts);
  /// False when rows stand for chosen cycles only.
  bool every_step() const { return cycles_ == 0; }
  /// Step of the last row that a resumed file kept, -1 without one. On all ranks.
  long last_step() const { return file_->last_step(); }

private:
  void append_contacts(HistoryFile::Row& row, const Snapshot& snapshot) const;
  void append_rigid_bodies(HistoryFile::Row& row, const Snapshot& snapshot) const;
  void append_cracks(HistoryFile::Row& row);
  void append_probes(HistoryFile::Row& row, const Snapshot& snapshot) const;
  void append_measures(HistoryFile::Row& row, const Snapshot& snapshot) const;
  void locate_probes();

  struct Located {
    int nodes[max_nodes];
    double N[max_nodes];
    int count = 0;         ///< 0 on ranks that do not hold the probe's cell
    std::size_t batch = 0; ///< of all groups' batches, and the lane: where cell fields have the cell
    std::size_t lane = 0;
  };
  const Scenario& scenario_;
  MotionProblem& motion_;
  const Ledger& ledger_;
  const StateRow& v_;
  const StateRow* phi_;
  const FieldSource& source_;
  std::optional<HistoryFile> file_;
  int cycles_ = 0; ///< of -ts_period between rows; 0: a row for each step
  std::vector<Located> probes_;
  std::vector<double> phi_before_; ///< [local node] of the row before
  struct CracksOf {
    std::size_t material;
    std::vector<int> nodes; ///< local
    StateRow& kept;         ///< of each crack a flag and its origin
  };
  std::vector<CracksOf> cracks_; ///< of each material with damage
};

} // namespace impact
