#pragma once
#include <impact/io/history_file.hpp>
#include <impact/math/vector3.hpp>
#include <impact/problem/motion.hpp>
#include <vector>

/// Supports act on bodies, and their nodes move: each condition has its force and, on rigid bodies,
/// the moment, of plane problems for the whole thickness; means over the condition's nodes.
namespace impact {

class Reactions {
public:
  Reactions(MotionProblem& motion, const StateTable& state);

  /// `force` [node][dim] closes the balance of momentum on prescribed dofs, at displacements u [node][dim].
  /// Collective.
  void find(const std::vector<double>& force, const std::vector<double>& u);
  /// Their columns; `heat` of each condition since t = 0 stands beside the temperature of thermal ones.
  void append(HistoryFile::Row& row, const std::function<double(std::size_t)>& heat) const;

private:
  struct OfCondition {
    std::vector<int> nodes; // owned
    Vector3 force{}, moment{}, mean{};
    double count = 0, mean_theta = 0;
  };
  bool turns(int condition, std::size_t axis) const; // prescribes a rotation of a rigid body

  MotionProblem& motion_;
  const StateRow* theta_;
  std::vector<OfCondition> of_;
};

} // namespace impact
