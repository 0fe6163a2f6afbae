#pragma once
#include <functional>
#include <impact/io/history_file.hpp>
#include <impact/math/vector3.hpp>
#include <impact/problem/motion.hpp>
#include <impact/solve/step_record.hpp>
#include <string>
#include <vector>

/// Boundary conditions act on bodies: forces and moments of supports, heat and entropy that came in; of plane
/// problems for the whole thickness.
namespace impact {

/// Each condition has its force and, on rigid bodies, the moment; means over the condition's nodes.
class Reactions {
public:
  Reactions(MotionProblem& motion, const StateTable& state);

  /// `force` [node][dim] closes the balance of momentum on prescribed dofs, at displacement u and velocity v.
  /// Collective.
  void find(const std::vector<double>& force, Vec u, Vec v);
  /// Their columns; `heat` of each condition since t = 0 stands beside the temperature of thermal ones.
  void append(HistoryFile::Row& row, const std::function<double(std::size_t)>& heat) const;

private:
  struct OfCondition {
    std::vector<int> nodes; // owned
    Vector3 force{}, moment{}, mean{};
    double mean_theta = 0;
  };
  bool turns(int condition, std::size_t axis) const; // prescribes a rotation of a rigid body

  MotionProblem& motion_;
  const StateRow* theta_;
  std::vector<OfCondition> of_;
};

/// Heat and entropy since t = 0, in global rows of the state table, so that a restart goes on with them: the
/// sums, and one of each thermal condition and contact, which a run may leave out or add.
class HeatBook {
public:
  /// Adds the rows. `contacts`: ids of those that pass heat.
  HeatBook(MotionProblem& motion, StateTable& state, std::vector<std::string> contacts);

  void start(double entropy) { totals_.trial.back() = entropy; }
  void book(const StepRecord& step, double thickness);

  /// By conditions, and by contacts from what is no body.
  double supplied() const { return totals_.trial[0]; }
  /// By all conditions and contacts, without regard to signs: what flows through a body in steady conduction
  /// is in no sum.
  double exchanged() const;
  double supplied_by(std::size_t thermal_condition) const { return conditions_[thermal_condition]->trial[0]; }
  /// Ids of the contacts that pass heat, and what was conducted into the secondary side of each.
  const std::vector<std::string>& contacts() const { return contacts_; }
  double conducted(std::size_t contact) const { return conducted_[contact]->trial[0]; }
  /// Entropy beside what was there at the start and came in.
  double entropy_produced(double entropy) const { return entropy - totals_.trial[1] - totals_.trial[2]; }

private:
  StateRow& totals_;                  ///< heat supplied, entropy supplied, entropy at the start
  std::vector<StateRow*> conditions_; ///< [condition], null unless it is thermal
  std::vector<std::string> contacts_;
  std::vector<StateRow*> conducted_; ///< [contact that passes heat]
};

} // namespace impact
