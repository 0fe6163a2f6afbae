#pragma once
#include <petscksp.h>

namespace impact {

/// Lets a factorisation or a hierarchy serve on, over iterations and steps, while that is cheaper than
/// another one: it is made again once the iterations that it took beyond those of a new one have cost what
/// making it costs, so that no choice in hindsight is better by more than a factor of two (the rule of ski
/// rental: A. Karlin et al., Algorithmica 3 (1988) 79).
class PreconditionerReuse {
public:
  /// `cost` of making it, in iterations; 0: a new one for each solve.
  explicit PreconditionerReuse(double cost) : cost_(cost) {}

  double cost() const { return cost_; }
  /// Whether the one that is there serves in the next solve. The same on all ranks.
  bool serves() const { return valid_; }
  /// Iterations for so many decades, after which one that serves on is given up.
  PetscInt most(double decades) const;
  /// To be told of each solve that converged, with the logarithm of what it reduced its residual by.
  void note(PetscInt iterations, double decades);
  /// There is none any more.
  void forget() { valid_ = false; }

private:
  double cost_, spent_ = 0;
  double rate_ = 0; // iterations for a decade when it was new
  bool valid_ = false;
};

} // namespace impact
