#pragma once
#include <impact/problem/motion.hpp>
#include <impact/solve/step_record.hpp>
#include <string>
#include <vector>

/// Heat and entropy that came into the bodies since t = 0, of plane problems for the whole thickness: one
/// global row of the state table, so that a restart goes on with it.
namespace impact {

class HeatBook {
public:
  /// Adds the row. Contacts that pass heat count where bodies move.
  HeatBook(MotionProblem& motion, StateTable& state, bool moves);

  void start(double entropy) { row_.trial.back() = entropy; }
  void book(const StepRecord& step, double thickness);

  /// By conditions, and by contacts from what is no body.
  double supplied() const;
  double supplied_by(std::size_t condition) const { return row_.trial[condition]; }
  /// Ids of the contacts that pass heat, and what was conducted into the secondary side of each.
  const std::vector<std::string>& contacts() const { return contacts_; }
  double conducted(std::size_t contact) const { return row_.trial[conditions_ + 2 * contact]; }
  /// Entropy beside what was there at the start and came in.
  double entropy_produced(double entropy) const {
    return entropy - row_.trial[row_.trial.size() - 2] - row_.trial.back();
  }

private:
  std::size_t conditions_;
  std::vector<std::string> contacts_;
  /// [condition], [contact]{conducted, from outside}, entropy supplied, entropy at the start
  StateRow& row_;
};

} // namespace impact
