#pragma once
#include <petscpc.h>

namespace impact {

/// Makes `pc` a preconditioner that factorises the block of `rows` in A and divides by the diagonal in the
/// others: for a matrix that its diagonal conditions well but in a few rows. `rows`: of this rank, whole
/// blocks of the matrix. Collective.
void factorise_rows(PC pc, Mat A, IS rows);

} // namespace impact
