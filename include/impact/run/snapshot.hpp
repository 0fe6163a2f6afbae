#pragma once
#include <petscvec.h>

/// What watchers of accepted steps are shown.
namespace impact {

/// An accepted state. Committed halves of the table hold it already.
struct Snapshot {
  long step = 0;
  double time = 0, dt = 0;
  int tries = 1;
  Vec u = nullptr;
};

/// Whether `time` is the start, or the middle or the end of a period number n, 2 n, ..
bool marks_cycle(double time, double period, int every);

} // namespace impact
