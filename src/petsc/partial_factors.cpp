#include <impact/petsc/field_solver.hpp>
#include <impact/petsc/handle.hpp>
#include <impact/petsc/partial_factors.hpp>
#include <petscksp.h>

namespace impact {

namespace {

struct PartialFactors {
  Handle<IS> rows;
  Handle<Vec> diagonal, right, left;
  Handle<Mat> block;
  Handle<KSP> factors;

  PartialFactors(Mat A, IS wanted) {
    check(PetscObjectReference(reinterpret_cast<PetscObject>(wanted)));
    rows = Handle<IS>(wanted);
    check(MatCreateVecs(A, diagonal.out(), nullptr));
    check(MatGetDiagonal(A, diagonal));
    if (Get(ISGetSize)(wanted) == 0) return;
    check(MatCreateSubMatrix(A, rows, rows, MAT_INITIAL_MATRIX, block.out()));
    check(MatCreateVecs(block, left.out(), right.out()));
    check(KSPCreate(PetscObjectComm(reinterpret_cast<PetscObject>(A)), factors.out()));
    check(KSPSetType(factors, KSPPREONLY));
    check(KSPSetOperators(factors, block, block));
    const PC pc = Get(KSPGetPC)(factors.get());
    check(PCSetType(pc, has_type(A, MATSEQSBAIJ, MATMPISBAIJ) ? PCCHOLESKY : PCLU));
    check(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
  }

  void apply(Vec x, Vec y) const {
    check(VecPointwiseDivide(y, x, diagonal));
    if (!factors) return;
    check(VecISCopy(x, rows, SCATTER_REVERSE, right));
    check(KSPSolve(factors, right, left));
    check(VecISCopy(y, rows, SCATTER_FORWARD, left));
  }
};

} // namespace

void factorise_rows(PC pc, Mat A, IS rows) {
  check(PCSetType(pc, PCNONE)); // what another matrix had goes
  check(PCSetType(pc, PCSHELL));
  check(PCShellSetContext(pc, new PartialFactors(A, rows)));
  check(PCShellSetApply(pc, [](PC shell, Vec x, Vec y) -> PetscErrorCode {
    PartialFactors* self = nullptr;
    if (const PetscErrorCode code = PCShellGetContext(shell, &self); code != 0) return code;
    return Mailbox().guarded([&] { self->apply(x, y); });
  }));
  check(PCShellSetDestroy(pc, [](PC shell) -> PetscErrorCode {
    PartialFactors* self = nullptr;
    const PetscErrorCode code = PCShellGetContext(shell, &self);
    delete self;
    return code;
  }));
}

} // namespace impact
