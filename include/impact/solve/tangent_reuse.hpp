#pragma once
#include <petscsnes.h>

/// Modified Newton where factorisations cost more than iterations: a factorised tangent serves on while each
/// iteration with it still reduces the residual enough, over all passes of a step.
namespace impact {

class TangentReuse {
public:
  /// `reduction`: largest quotient of two residual norms in a row at which the tangent serves on; 0: full
  /// Newton.
  explicit TangentReuse(double reduction) : reduction_(reduction) {}

  /// To be asked once in each iteration of `snes`, with what the tangent depends on beside the state. The
  /// same on all ranks.
  bool serves(SNES snes, PetscReal dt, PetscReal shift);
  double reduction() const { return reduction_; }
  /// The matrix holds something else, or nothing any more.
  void forget() { valid_ = false; }

private:
  double reduction_;
  bool valid_ = false;
  PetscReal dt_ = 0, shift_ = 0, norm_ = 0;
};

} // namespace impact
