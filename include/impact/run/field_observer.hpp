#pragma once
#include <impact/io/field_output.hpp>
#include <impact/run/field_source.hpp>
#include <impact/run/snapshot.hpp>
#include <impact/scenario/scenario.hpp>

namespace impact {

/// The field files of one output.
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

} // namespace impact
