#pragma once
#include <petscksp.h>

namespace impact {

/// Leaves `ksp` as if it had never solved: factors, hierarchies, and what a preconditioner keeps beside them.
/// Collective.
void forget_factors(KSP ksp);

} // namespace impact
