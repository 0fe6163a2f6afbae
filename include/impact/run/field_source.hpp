#pragma once
#include <impact/problem/motion.hpp>

/// What files, probes and measures show of a run. Reads committed state only.
namespace impact {

/// A field over the mesh.
struct FieldValues {
  bool nodal;
  int components;
  std::vector<double> values; ///< [local node][component], or of cells [group][batch][component][lane]
};

/// Fields by name: nodal ones from the state table, cell ones from the law, contact ones from the interfaces.
class FieldSource {
public:
  FieldSource(MotionProblem& motion, const StateTable& state) : motion_(motion), state_(state) {}
  /// Throws UserError(usage) for a field that an option asks for and the run cannot give, or not on the group
  /// `no_region`, if any, where cells have no values.
  void require(const std::string& key, const std::string& name, const std::string& no_region = "") const;
  /// At the solution u, which is committed. Collective.
  FieldValues values(const std::string& name, Vec u) const;

private:
  std::vector<double> cell_means(const std::string& name, int components) const;

  MotionProblem& motion_;
  const StateTable& state_;
};

} // namespace impact
