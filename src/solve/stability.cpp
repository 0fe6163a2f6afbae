#include <impact/petsc/error.hpp>
#include <impact/petsc/field_solver.hpp>
#include <impact/solve/stability.hpp>

namespace impact {

namespace {

PetscInt negative_pivots(Mat A) {
  Handle<Mat> factors;
  Handle<IS> rows, columns;
  MatFactorInfo how;
  check(MatFactorInfoInitialize(&how));
  check(MatGetFactor(A, MATSOLVERMUMPS, MAT_FACTOR_CHOLESKY, factors.out()));
  check(MatMumpsSetIcntl(factors, 13, 1)); // pivots of a root that ranks share by ScaLAPACK are not counted
  check(MatCholeskyFactorSymbolic(factors, A, nullptr, &how));
  check(MatCholeskyFactorNumeric(factors, A, &how));
  PetscInt negative = 0;
  check(MatMumpsGetInfog(factors, 12, &negative));
  return negative;
}

} // namespace

std::string tell_of_instability(MotionProblem& motion, Vec u) {
  const bool shell = motion.jacobian() != motion.matrix();
  if (shell || !is_factorised(motion.discretisation().mesh) || motion.contacts().demands().closes_gaps ||
      !motion.tangent(u, 0))
    return "";
  const PetscInt modes = negative_pivots(motion.matrix());
  if (modes <= 0) return "";
  return text_of("impact: WARNING: the equilibrium at the end is unstable, its tangent has %d negative "
                 "eigenvalue%s: a load where bodies buckle or snap was passed, and real ones leave this "
                 "branch; give them an imperfection of the shape or a small load aside, or take inertia "
                 "(-ts_type newmark)\n",
                 static_cast<int>(modes), modes == 1 ? "" : "s");
}

} // namespace impact
