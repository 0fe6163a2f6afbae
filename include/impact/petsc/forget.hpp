#pragma once
#include <petscsnes.h>

namespace impact {

/// Leaves the linear solver of `snes` as if it had never solved: factors, hierarchies, and what a
/// preconditioner keeps beside them. Collective.
void forget_factors(SNES snes);

} // namespace impact
