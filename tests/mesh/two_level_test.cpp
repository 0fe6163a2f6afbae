#include <cmath>
#include <gtest/gtest.h>
#include <impact/mesh/two_level.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/field_solver.hpp>
#include <impact/petsc/handle.hpp>
#include <string>

using namespace impact;

namespace {

// Finite differences of -Laplace u = f per component on a cube of n^3 nodes, u = 0 around it: node-blocked,
// by slices of the cube on the ranks, so that it is symmetric and positive definite.
Handle<Mat> laplace(PetscInt n, PetscInt components, MatType type) {
  Handle<Mat> A;
  PetscInt own = PETSC_DECIDE, all = n * n * n * components;
  check(PetscSplitOwnershipBlock(PETSC_COMM_WORLD, components, &own, &all));
  check(MatCreate(PETSC_COMM_WORLD, A.out()));
  check(MatSetSizes(A, own, own, all, all));
  check(MatSetBlockSize(A, components));
  check(MatSetType(A, type));
  check(MatSeqAIJSetPreallocation(A, 7 * components, nullptr));
  check(MatMPIAIJSetPreallocation(A, 7 * components, nullptr, 7 * components, nullptr));
  check(MatSeqSBAIJSetPreallocation(A, components, 7, nullptr));
  check(MatMPISBAIJSetPreallocation(A, components, 7, nullptr, 7, nullptr));
  if (has_type(A.get(), MATSEQSBAIJ, MATMPISBAIJ))
    check(MatSetOption(A, MAT_IGNORE_LOWER_TRIANGULAR, PETSC_TRUE));
  PetscInt first = 0, end = 0;
  check(MatGetOwnershipRange(A, &first, &end));
  for (PetscInt row = first; row < end; ++row) {
    const PetscInt node = row / components, place[3] = {node % n, node / n % n, node / n / n};
    const PetscInt stride[3] = {components, n * components, n * n * components};
    check(MatSetValue(A, row, row, 6, INSERT_VALUES));
    for (int k = 0; k < 3; ++k) {
      if (place[k] > 0) check(MatSetValue(A, row, row - stride[k], -1, INSERT_VALUES));
      if (place[k] + 1 < n) check(MatSetValue(A, row, row + stride[k], -1, INSERT_VALUES));
    }
  }
  check(MatAssemblyBegin(A, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(A, MAT_FINAL_ASSEMBLY));
  return A;
}

Handle<KSP> solver(Mat A, PCType type, const std::string& options = "") {
  Handle<KSP> ksp;
  register_two_level();
  check(PetscOptionsInsertString(nullptr, options.c_str()));
  check(KSPCreate(PETSC_COMM_WORLD, ksp.out()));
  check(KSPSetOptionsPrefix(ksp, "levels_"));
  check(KSPSetOperators(ksp, A, A));
  check(KSPSetType(ksp, KSPCG));
  check(KSPSetTolerances(ksp, 1e-6, 0, PETSC_DEFAULT, 1000));
  check(PCSetType(Get(KSPGetPC)(ksp.get()), type));
  check(KSPSetFromOptions(ksp));
  check(PetscOptionsClearValue(nullptr, "-levels_pc_two_level_nodes"));
  return ksp;
}

// Iterations until the residual of a rough right-hand side has fallen by 1e-6.
PetscInt iterations(PetscInt n, PetscInt components, MatType format, PCType type) {
  const Handle<Mat> A = laplace(n, components, format);
  const Handle<KSP> ksp = solver(A, type);
  Handle<Vec> x, b;
  check(MatCreateVecs(A, x.out(), b.out()));
  PetscInt first = 0, end = 0;
  check(VecGetOwnershipRange(b, &first, &end));
  for (PetscInt i = first; i < end; ++i)
    check(VecSetValue(b, i, std::sin(1.3 * static_cast<double>(i)) + 1, INSERT_VALUES));
  check(VecAssemblyBegin(b));
  check(VecAssemblyEnd(b));
  check(KSPSolve(ksp, b, x));
  EXPECT_GT(Get(KSPGetConvergedReason)(ksp.get()), 0);
  Handle<Vec> left;
  check(VecDuplicate(b, left.out()));
  check(MatMult(A, x, left));
  check(VecAXPY(left, -1, b));
  EXPECT_LT(Get(VecNorm)(left.get(), NORM_2), 1e-4 * Get(VecNorm)(b.get(), NORM_2));
  return Get(KSPGetIterationNumber)(ksp.get());
}

} // namespace

TEST(TwoLevel, IterationsDoNotGrowWithTheBody) {
  const PetscInt coarse = iterations(20, 1, MATAIJ, two_level_type),
                 fine = iterations(40, 1, MATAIJ, two_level_type),
                 alone = iterations(40, 1, MATAIJ, PCJACOBI);
  EXPECT_LE(fine, 1.2 * coarse);
  EXPECT_LT(fine, 0.6 * alone);
}

TEST(TwoLevel, UpperBlocksAreTheWholeMatrix) {
  EXPECT_NEAR(iterations(12, 3, MATAIJ, two_level_type), iterations(12, 3, MATSBAIJ, two_level_type), 1);
  EXPECT_NEAR(iterations(12, 1, MATAIJ, two_level_type), iterations(12, 3, MATAIJ, two_level_type), 1);
}

// M^-1 A p = p + D^-1 A p for p in the range of P: constants, on one aggregate for each rank.
TEST(TwoLevel, TheCoarseProblemIsSolvedExactly) {
  for (const MatType format : {MATAIJ, MATSBAIJ}) {
    const Handle<Mat> A = laplace(6, 3, format);
    const Handle<KSP> ksp = solver(A, two_level_type, "-levels_pc_two_level_nodes 1000");
    Handle<Vec> p, Ap, z, diagonal;
    check(MatCreateVecs(A, p.out(), Ap.out()));
    check(VecDuplicate(p, z.out()));
    check(VecDuplicate(p, diagonal.out()));
    check(VecSet(p, 1));
    check(MatMult(A, p, Ap));
    check(KSPSetUp(ksp));
    check(PCApply(Get(KSPGetPC)(ksp.get()), Ap, z));
    check(MatGetDiagonal(A, diagonal));
    check(VecPointwiseDivide(Ap, Ap, diagonal));
    check(VecAXPY(z, -1, Ap));
    check(VecAXPY(z, -1, p));
    EXPECT_LT(Get(VecNorm)(z.get(), NORM_INFINITY), 1e-12);
  }
}

// Rows that are joined to no other one, as those of prescribed dofs are, keep out of the coarse problem.
TEST(TwoLevel, AloneStandingRowsAreSolvedByTheirDiagonal) {
  const Handle<Mat> A = laplace(6, 1, MATAIJ);
  PetscInt first = 0, end = 0;
  check(MatGetOwnershipRange(A, &first, &end));
  std::vector<PetscInt> rows;
  for (PetscInt r = first; r < std::min(end, first + 8); ++r) rows.push_back(r);
  check(MatZeroRowsColumns(A, static_cast<PetscInt>(rows.size()), rows.data(), 4, nullptr, nullptr));
  const Handle<KSP> ksp = solver(A, two_level_type);
  Handle<Vec> r, z;
  check(MatCreateVecs(A, r.out(), z.out()));
  for (const PetscInt row : rows) check(VecSetValue(r, row, 8, INSERT_VALUES));
  check(VecAssemblyBegin(r));
  check(VecAssemblyEnd(r));
  check(KSPSetUp(ksp));
  check(PCApply(Get(KSPGetPC)(ksp.get()), r, z));
  check(VecAXPY(z, -0.25, r));
  EXPECT_LT(Get(VecNorm)(z.get(), NORM_INFINITY), 1e-14);
}
