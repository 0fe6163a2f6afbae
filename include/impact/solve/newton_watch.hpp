#pragma once
#include <vector>

/// Tells from the norms of its residuals when Newton's method will not converge: where an active set does not
/// come to rest the iterates go round in circles, and steps taken in full that hardly change the residual
/// close nothing any more. What converges shows neither.
namespace impact {

class NewtonWatch {
public:
  /// `full_steps`: no line search, whose short steps may change the residual little and lead on.
  void start(bool full_steps);
  /// To be told the norm at every iterate, the first one included.
  void note(double norm);
  /// Iterates of the cycle in which the norms end, or 0: all norms of the last round are those of the round
  /// before to 4 %, of a cycle of two or three those of the last four iterates; the norms within it differ by
  /// more than a tenth. A cycle of n iterates is seen after 2 n of them, or n + 4 if that is more.
  int cycle() const;
  /// Whether each of the last five full steps changed the norm by less than a tenth, or lowered it by less
  /// than a third where it is a thousandth of the first one already.
  bool stalls() const { return full_steps_ && unchanged_ >= 5; }

private:
  bool full_steps_ = false;
  int unchanged_ = 0; ///< steps in a row that did so
  std::vector<double> norms_;
};

} // namespace impact
