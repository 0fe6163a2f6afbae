#pragma once
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

/// The one table of state (rollback, checkpoint, load on other ranks, output walk it; new physics adds a
/// row).
namespace impact {

enum class Support {
  vertex,      ///< [local node][component], ghosts included and consistent
  cell_point,  ///< [group][batch][point][component][lane], groups in the order of the cell groups,
               ///< concatenated
  facet_point, ///< [facet][point][component] of a contact surface's own facets
  global       ///< [component], equal on all ranks
};

struct StateRow {
  std::string name; ///< unique; names the data set in a checkpoint
  Support support;
  int components;
  bool has_trial = true; ///< a trial half exists and is committed on acceptance
  bool checkpointed = true;
  bool output = false;    ///< offered as an output field
  bool rewritten = false; ///< every step writes all of the trial half, which a commit leaves undefined
  std::string surface{};  ///< facet_point rows: the boundary group their facets belong to
  std::vector<double> committed{}, trial{};
};

class StateTable {
public:
  /// Adds a row of `size` doubles, all set to `initial`. The reference stays valid.
  /// Throws std::logic_error for a name that is already there or a size that is no multiple of the
  /// components.
  StateRow& add(StateRow row, std::size_t size, double initial = 0);
  /// Throws std::out_of_range, naming the row, when there is none.
  StateRow& row(const std::string& name);
  const StateRow& row(const std::string& name) const;
  /// The row or null.
  const StateRow* find(const std::string& name) const;
  const std::vector<std::unique_ptr<StateRow>>& rows() const { return rows_; }
  void
  commit(); ///< accepted step: trial halves become committed; but for `rewritten` rows both are equal then
  void rollback(); ///< rejected step or new pass: trial halves restart from committed

private:
  std::vector<std::unique_ptr<StateRow>> rows_;
};

} // namespace impact
