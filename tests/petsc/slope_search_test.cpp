#include <cmath>
#include <gtest/gtest.h>
#include <impact/petsc/error.hpp>
#include <impact/petsc/field_solver.hpp>
#include <impact/petsc/handle.hpp>
#include <impact/petsc/slope_search.hpp>
#include <string>

using namespace impact;

namespace {

/// Slope and curvature of an energy of one unknown; no number where it has none.
struct Energy {
  double (*slope)(double), (*curvature)(double);
};

PetscErrorCode residual(SNES snes, Vec x, Vec f, void* energy) {
  return guarded([&] {
    PetscScalar at = 0;
    const PetscInt row = 0;
    check(VecGetValues(x, 1, &row, &at));
    const double slope = static_cast<Energy*>(energy)->slope(at);
    if (std::isnan(slope)) return check(SNESSetFunctionDomainError(snes));
    check(VecSet(f, slope));
  });
}

PetscErrorCode tangent(SNES, Vec x, Mat, Mat K, void* energy) {
  return guarded([&] {
    PetscScalar at = 0;
    const PetscInt row = 0;
    check(VecGetValues(x, 1, &row, &at));
    check(MatSetValue(K, 0, 0, static_cast<Energy*>(energy)->curvature(at), INSERT_VALUES));
    check(MatAssemblyBegin(K, MAT_FINAL_ASSEMBLY));
    check(MatAssemblyEnd(K, MAT_FINAL_ASSEMBLY));
  });
}

/// Where Newton's method with this search ends; no number where it does not converge.
double root_from(double start, Energy energy, const std::string& search) {
  Handle<SNES> snes;
  Handle<Vec> x, f;
  Handle<Mat> K;
  register_slope_search();
  check(VecCreateSeq(PETSC_COMM_SELF, 1, x.out()));
  check(VecDuplicate(x, f.out()));
  check(MatCreateSeqDense(PETSC_COMM_SELF, 1, 1, nullptr, K.out()));
  check(SNESCreate(PETSC_COMM_SELF, snes.out()));
  check(SNESSetFunction(snes, f, residual, &energy));
  check(SNESSetJacobian(snes, K, K, tangent, &energy));
  check(SNESSetTolerances(snes, 1e-12, 0, 0, 25, PETSC_DEFAULT));
  const KSP ksp = Get(SNESGetKSP)(snes);
  check(KSPSetType(ksp, KSPPREONLY));
  check(PCSetType(Get(KSPGetPC)(ksp), PCLU));
  check(SNESLineSearchSetType(Get(SNESGetLineSearch)(snes), search.c_str()));
  check(VecSet(x, start));
  check(SNESSolve(snes, nullptr, x));
  PetscScalar end = 0;
  const PetscInt row = 0;
  check(VecGetValues(x, 1, &row, &end));
  return Get(SNESGetConvergedReason)(snes) > 0 ? end : NAN;
}

const Energy two_wells = {[](double x) { return x * x * x - x; }, [](double x) { return 3 * x * x - 1; }};
// The residual has a smallest norm of 0.115 at 0.577, between 1 and the only root.
const Energy tilted = {[](double x) { return x * x * x - x + 0.5; }, two_wells.curvature};
const Energy barrier = {[](double x) { return x > 0 ? 1 - 1 / x : NAN; },
                        [](double x) { return 1 / (x * x); }};

} // namespace

TEST(SlopeSearch, GoesDownFromAMaximum) {
  EXPECT_NEAR(root_from(0.45, two_wells, SNESLINESEARCHBASIC), -1, 1e-9); // beyond the maximum
  EXPECT_NEAR(root_from(0.45, two_wells, slope_search_type), 1, 1e-9);
  EXPECT_NEAR(root_from(-0.45, two_wells, slope_search_type), -1, 1e-9);
}

TEST(SlopeSearch, PassesWhatIsTheSmallestResidualButNone) {
  const double root = root_from(1, tilted, slope_search_type);
  EXPECT_NEAR(root * root * root - root, -0.5, 1e-11);
  EXPECT_TRUE(std::isnan(root_from(1, tilted, SNESLINESEARCHBT)));
}

TEST(SlopeSearch, StaysWhereTheEnergyHasAValue) {
  EXPECT_NEAR(root_from(10, barrier, slope_search_type), 1, 1e-9);
  EXPECT_TRUE(std::isnan(root_from(10, barrier, SNESLINESEARCHBASIC)));
}

TEST(SlopeSearch, TakesWholeStepsNearTheSolution) {
  // Two iterations of Newton's method from 1.05 leave 1e-5, four 1e-16.
  EXPECT_NEAR(root_from(1.05, two_wells, slope_search_type), 1, 1e-12);
}
