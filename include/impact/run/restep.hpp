#pragma once
#include <impact/time/step_control.hpp>
#include <impact/time/types.hpp>

namespace impact {

/// -test_restep: every step is tried, refused and tried again with the same dt, so that what a refused step
/// leaves behind shows in the results.
class Restep {
public:
  explicit Restep(bool wanted) : wanted_(wanted) {}

  void before_attempt(TS ts) {
    if (repeats_) set_step_control_state(ts, before_repeat_);
  }
  /// Whether an accepted step is to be tried once more.
  bool wants(TS ts, const Verdict& verdict) {
    const bool first = !repeats_;
    repeats_ = false;
    if (!wanted_ || !verdict.accept || !first) return false;
    repeats_ = forced_ = true;
    before_repeat_ = step_control_state(ts);
    return true;
  }
  /// Whether the refusal was its own.
  bool refused() {
    const bool mine = forced_;
    if (!mine) repeats_ = false;
    forced_ = false;
    return mine;
  }

private:
  bool wanted_, repeats_ = false, forced_ = false;
  StepControlState before_repeat_;
};

} // namespace impact
