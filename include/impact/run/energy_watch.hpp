#pragma once
#include <impact/run/stage.hpp>

/// A run warns, cuts steps or ends when more energy comes from nowhere or is lost than -energy_tol allows,
/// and ends beyond -energy_stop (theory.md, 11).
namespace impact {

class EnergyWatch {
public:
  /// Adds its row to the table: steps beyond each of the two bounds. The stage must outlive it.
  explicit EnergyWatch(RunStage& stage);

  /// Judges the attempt at a step that the ledger has booked; `before` is the error that it had until then.
  /// Throws UserError(solver). Collective.
  Verdict judge(double before, const Attempt& attempt);
  /// Says what there is to say of the balance at the end. Collective.
  void report_end(double t) const;

private:
  bool leaps(double before, const Attempt& attempt) const;
  bool beyond(std::size_t which, double bound, double before);
  void tell_of_impacts() const;
  void tell_of_penalties() const;
  void tell_of_flutter() const;
  void tell_of_untouched() const;
  void tell_of_small_loads() const;
  std::string text(double t, const char* option, double bound) const;
  std::string remedy() const;
  std::string step_remedy() const;

  RunStage& stage_;
  StateRow& steps_beyond_; ///< [bound]: -energy_tol, -energy_stop
  double least_; ///< energy of bodies strained by 1e-7: below it the first law is one of rounding errors
  std::string warning_;                    ///< the first one
  double most_held_ = 0, strain_then_ = 0; ///< by penalties of contacts, and by bodies at that time
};

} // namespace impact
