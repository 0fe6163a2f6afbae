#include <algorithm>
#include <impact/petsc/error.hpp>
#include <impact/petsc/field_solver.hpp>
#include <string>

namespace impact {

void allow_rounding(SNES snes, Vec sizes) {
  PetscReal size = 0, atol = 0;
  check(VecNorm(sizes, NORM_2, &size));
  check(SNESGetTolerances(snes, &atol, nullptr, nullptr, nullptr, nullptr));
  check(SNESSetTolerances(snes, std::max(atol, 1e-15 * size), PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT,
                          PETSC_DEFAULT));
}

SNESConvergedReason reason_by_residual(SNES snes) {
  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  PetscReal norm = 0, atol = 0;
  check(SNESGetConvergedReason(snes, &reason));
  check(SNESGetFunctionNorm(snes, &norm));
  check(SNESGetTolerances(snes, &atol, nullptr, nullptr, nullptr, nullptr));
  if (reason == SNES_DIVERGED_LINE_SEARCH && norm <= atol) return SNES_CONVERGED_FNORM_ABS;
  if (reason > 0 && reason != SNES_CONVERGED_FNORM_ABS && reason != SNES_CONVERGED_FNORM_RELATIVE)
    return SNES_DIVERGED_LINE_SEARCH;
  return reason;
}

ScalarOutcome solve_field(SNES snes, Vec x, Mailbox& mailbox) {
  ScalarOutcome outcome;
  mailbox.deliver(SNESSolve(snes, nullptr, x));
  outcome.reason = reason_by_residual(snes);
  check(SNESGetIterationNumber(snes, &outcome.newton));
  check(SNESGetLinearSolveIterations(snes, &outcome.linear));
  return outcome;
}

void set_scalar_solver_defaults(KSP ksp, const char* prefix) {
  PC pc = nullptr;
  check(KSPSetType(ksp, KSPCG));
  check(KSPSetTolerances(ksp, 1e-10, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  check(KSPGetPC(ksp, &pc));
  int ranks = 1;
  MPI_Comm_size(PetscObjectComm(reinterpret_cast<PetscObject>(ksp)), &ranks);
  if (ranks == 1) return check(PCSetType(pc, PCICC));
  // Conjugate gradients want symmetric blocks; bjacobi would factorise them by ILU.
  check(PCSetType(pc, PCBJACOBI));
  const std::string inner = "-" + std::string(prefix) + "sub_pc_type";
  PetscBool set = PETSC_FALSE;
  check(PetscOptionsHasName(nullptr, nullptr, inner.c_str(), &set));
  if (!set) check(PetscOptionsSetValue(nullptr, inner.c_str(), "icc"));
}

std::string linear_solver_text(SNES snes) {
  KSP ksp = nullptr;
  PC pc = nullptr;
  KSPType krylov = nullptr;
  PCType type = nullptr;
  MatSolverType package = nullptr;
  check(SNESGetKSP(snes, &ksp));
  check(KSPGetPC(ksp, &pc));
  check(KSPGetType(ksp, &krylov));
  check(PCGetType(pc, &type));
  check(PCFactorGetMatSolverType(pc, &package)); // none of a type that has no factors
  return std::string(krylov ? krylov : "gmres") + " + " + (type ? type : "PETSc's choice") +
         (package ? std::string(" by ") + package : "");
}

void forget_factors(SNES snes) {
  KSP ksp = nullptr;
  check(SNESGetKSP(snes, &ksp));
  check(KSPReset(ksp));
  PC pc = nullptr;
  PetscBool gamg = PETSC_FALSE;
  check(KSPGetPC(ksp, &pc));
  check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(pc), PCGAMG, &gamg));
  if (!gamg) return;
  // The solvers of its levels outlive a reset with what they had set up: the next hierarchy is another one
  // by 1e-4 than that of a new object.
  check(PCSetType(pc, PCNONE));
  check(PCSetType(pc, PCGAMG));
  check(PCSetFromOptions(pc));
}

} // namespace impact
