#pragma once
#include <impact/run/stage.hpp>
#include <string>

/// What a run does about energy that comes from nowhere or is lost (theory.md, 11): warns, cuts steps or ends
/// beyond -energy_tol, ends beyond -energy_stop.
namespace impact {

class EnergyWatch {
public:
  /// Adds its row to the table: steps in a row beyond each of the two bounds. The stage must outlive it.
  explicit EnergyWatch(RunStage& stage);

  /// Judges the step to t that the ledger has booked; `before` is the error that it had until then. Throws
  /// UserError(solver). Collective.
  Verdict judge(double before, double t);
  /// What is to be said of the balance at the end. Collective.
  void report_end(double t) const;

private:
  bool beyond(std::size_t which, double bound);
  std::string text(double t, const char* option, double bound) const;
  std::string remedy() const;

  RunStage& stage_;
  StateRow& steps_beyond_; ///< [bound]: -energy_tol, -energy_stop
  double least_; ///< energy of bodies strained by 1e-7: below it the first law is one of rounding errors
  std::string warning_; ///< the first one
};

} // namespace impact
