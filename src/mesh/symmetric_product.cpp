#include "matrix_formats.hpp"
#include <algorithm>
#include <experimental/simd>
#include <impact/petsc/error.hpp>

namespace impact {

namespace {

using Pair = std::experimental::fixed_size_simd<double, 2>;

Pair pair_at(const double* values) { return {values, std::experimental::element_aligned}; }

// y = A x for blocks on and above the diagonal, each stored by columns. The sums of a row stand apart for
// each column of a block, so that none waits for another.
template <int c>
void multiply(PetscInt rows, const PetscInt* start, const PetscInt* column, const double* value,
              const double* x, double* y) {
  const auto at = [](PetscInt node) { return static_cast<std::ptrdiff_t>(node) * c; };
  std::fill(y, y + at(rows), 0.0);
  for (PetscInt row = 0; row < rows; ++row) {
    double own[c], third[c] = {};
    Pair sum[c];
    for (int j = 0; j < c; ++j) own[j] = x[at(row) + j], sum[j] = 0;
    const auto add = [&](const double* other) {
      for (int j = 0; j < c; ++j) {
        sum[j] += pair_at(value + j * c) * other[j];
        if (c == 3) third[j] += value[j * c + 2] * other[j];
      }
    };
    PetscInt k = start[row];
    const PetscInt end = start[row + 1];
    if (k < end && column[k] == row) {
      add(own);
      value += c * c;
      ++k;
    }
    for (; k < end; ++k, value += c * c) {
      add(x + at(column[k]));
      double below[c] = {};
      for (int j = 0; j < c; ++j)
        for (int i = 0; i < c; ++i) below[j] += value[j * c + i] * own[i];
      for (int j = 0; j < c; ++j) y[at(column[k]) + j] += below[j];
    }
    for (int j = 0; j < c; ++j) {
      y[at(row)] += sum[j][0];
      y[at(row) + 1] += sum[j][1];
      if (c == 3) y[at(row) + 2] += third[j];
    }
  }
}

template <int c> PetscErrorCode mat_mult(Mat matrix, Vec x, Vec y) {
  Mailbox mailbox; // an exception has no way through PETSc
  return mailbox.guarded([&] {
    PetscInt rows = 0;
    const PetscInt *start = nullptr, *column = nullptr;
    PetscBool done = PETSC_FALSE;
    double* values = nullptr;
    const double* from = nullptr;
    double* to = nullptr;
    check(MatGetRowIJ(matrix, 0, PETSC_FALSE, PETSC_TRUE, &rows, &start, &column, &done));
    check(MatSeqSBAIJGetArray(matrix, &values));
    check(VecGetArrayRead(x, &from));
    check(VecGetArrayWrite(y, &to));
    multiply<c>(rows, start, column, values, from, to);
    check(PetscLogFlops(2.0 * c * c * (2.0 * start[rows] - rows)));
    check(VecRestoreArrayWrite(y, &to));
    check(VecRestoreArrayRead(x, &from));
    check(MatSeqSBAIJRestoreArray(matrix, &values));
    check(MatRestoreRowIJ(matrix, 0, PETSC_FALSE, PETSC_TRUE, &rows, &start, &column, &done));
  });
}

} // namespace

void use_own_product(Mat matrix) {
  PetscInt size = 0;
  check(MatGetBlockSize(matrix, &size));
  PetscErrorCode (*product)(Mat, Vec, Vec) = size == 2 ? mat_mult<2> : size == 3 ? mat_mult<3> : nullptr;
  if (product) check(MatSetOperation(matrix, MATOP_MULT, reinterpret_cast<void (*)()>(product)));
}

} // namespace impact
