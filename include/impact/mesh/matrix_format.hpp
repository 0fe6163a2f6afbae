#pragma once

namespace impact {

/// How PETSc stores a matrix of nodal blocks: all entries, or the blocks on and above the diagonal.
enum class MatrixFormat { aij, sbaij };

} // namespace impact
