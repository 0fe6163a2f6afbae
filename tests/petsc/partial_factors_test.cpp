#include <cmath>
#include <gtest/gtest.h>
#include <impact/petsc/field_solver.hpp>
#include <impact/petsc/handle.hpp>
#include <impact/petsc/partial_factors.hpp>
#include <petscksp.h>
#include <vector>

using namespace impact;

namespace {

constexpr PetscInt nodes = 400, components = 2, near = 7;

bool is_pressed(PetscInt node) { return node % 20 < 2; }

void add(Mat A, PetscInt row, PetscInt column, double value) {
  const bool half = has_type(A, MATSEQSBAIJ, MATMPISBAIJ);
  if (!half || column >= row) check(MatSetValue(A, row, column, value, ADD_VALUES));
}

// The mass of a chain of bars, with springs between pairs of its nodes that are 1e6 to 1e9 times as large:
// what contact adds to a mass. `pressed`: without them the mass alone.
Handle<Mat> mass(MatType format, bool pressed) {
  Handle<Mat> A;
  PetscInt own = PETSC_DECIDE, all = nodes * components;
  check(PetscSplitOwnershipBlock(PETSC_COMM_WORLD, components, &own, &all));
  check(MatCreate(PETSC_COMM_WORLD, A.out()));
  check(MatSetSizes(A, own, own, all, all));
  check(MatSetBlockSize(A, components));
  check(MatSetType(A, format));
  check(MatSeqAIJSetPreallocation(A, near * components, nullptr));
  check(MatMPIAIJSetPreallocation(A, near * components, nullptr, near * components, nullptr));
  check(MatSeqSBAIJSetPreallocation(A, components, near, nullptr));
  check(MatMPISBAIJSetPreallocation(A, components, near, nullptr, near, nullptr));
  PetscInt first = 0, end = 0;
  check(MatGetOwnershipRange(A, &first, &end));
  for (PetscInt row = first; row < end; ++row) {
    const PetscInt node = row / components;
    add(A, row, row, 4);
    if (node > 0) add(A, row, row - components, 1);
    if (node + 1 < nodes) add(A, row, row + components, 1);
    if (!pressed || !is_pressed(node)) continue;
    const PetscInt other = node % 20 == 0 ? row + components : row - components;
    const double spring = std::pow(10, 6 + (node / 20) % 4);
    add(A, row, row, spring);
    add(A, row, other, -spring);
  }
  check(MatAssemblyBegin(A, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(A, MAT_FINAL_ASSEMBLY));
  return A;
}

Handle<IS> pressed_rows(Mat A, bool pressed) {
  PetscInt first = 0, end = 0;
  check(MatGetOwnershipRange(A, &first, &end));
  std::vector<PetscInt> list;
  for (PetscInt node = first / components; pressed && node < end / components; ++node)
    if (is_pressed(node)) list.push_back(node);
  Handle<IS> rows;
  check(ISCreateBlock(PETSC_COMM_WORLD, components, static_cast<PetscInt>(list.size()), list.data(),
                      PETSC_COPY_VALUES, rows.out()));
  return rows;
}

// Iterations of GMRES until the residual has fallen by 1e-10; twice with the same solver, as contact presses
// on other rows each time.
PetscInt iterations(MatType format, bool factorised) {
  Handle<KSP> ksp;
  check(KSPCreate(PETSC_COMM_WORLD, ksp.out()));
  check(KSPSetType(ksp, KSPGMRES));
  check(KSPSetTolerances(ksp, 1e-10, 0, PETSC_DEFAULT, 200));
  PetscInt most = 0;
  for (const bool pressed : {true, false, true}) {
    const Handle<Mat> A = mass(format, pressed);
    check(KSPSetOperators(ksp, A, A));
    const PC pc = Get(KSPGetPC)(ksp.get());
    if (factorised)
      factorise_rows(pc, A, pressed_rows(A, pressed));
    else
      check(PCSetType(pc, PCJACOBI));
    Handle<Vec> x, b;
    check(MatCreateVecs(A, x.out(), b.out()));
    check(VecSet(x, 1));
    check(MatMult(A, x, b));
    check(VecSetValue(b, 3, 2, ADD_VALUES)); // on each rank
    check(VecAssemblyBegin(b));
    check(VecAssemblyEnd(b));
    check(KSPSolve(ksp, b, x));
    most = std::max(most, Get(KSPGetIterationNumber)(ksp.get()));
    if (!factorised) continue;
    EXPECT_GT(Get(KSPGetConvergedReason)(ksp.get()), 0);
    Handle<Vec> left;
    check(VecDuplicate(b, left.out()));
    check(MatMult(A, x, left));
    check(VecAXPY(left, -1, b));
    EXPECT_LT(Get(VecNorm)(left.get(), NORM_2), 1e-8 * Get(VecNorm)(b.get(), NORM_2));
  }
  return most;
}

} // namespace

TEST(PartialFactors, ConditionAMassWithPenaltiesAsTheMassAlone) {
  for (const MatType format : {MATAIJ, MATSBAIJ}) {
    EXPECT_LT(iterations(format, true), 40);
    EXPECT_GT(iterations(format, false), 60);
  }
}
