#pragma once
#include <petscmat.h>

namespace impact {

/// The number of products with `A` that take the time of its factorisation by MUMPS, from the operations that
/// the analysis of its pattern foresees. A of type aij or, symmetric, sbaij. Collective.
double products_for_factors(Mat A);

} // namespace impact
