#include <algorithm>
#include <impact/petsc/error.hpp>
#include <impact/petsc/field_solver.hpp>
#include <string>

namespace impact {

void allow_rounding(SNES snes, Vec sizes) {
  PetscReal atol = 0;
  const PetscReal size = Get(VecNorm)(sizes, NORM_2);
  check(SNESGetTolerances(snes, &atol, nullptr, nullptr, nullptr, nullptr));
  check(SNESSetTolerances(snes, std::max(atol, 1e-15 * size), PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT,
                          PETSC_DEFAULT));
}

SNESConvergedReason reason_by_residual(SNES snes) {
  PetscReal atol = 0;
  const SNESConvergedReason reason = Get(SNESGetConvergedReason)(snes);
  const PetscReal norm = Get(SNESGetFunctionNorm)(snes);
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

std::string linear_solver_text(SNES snes) {
  MatSolverType package = nullptr;
  const KSP ksp = Get(SNESGetKSP)(snes);
  const PC pc = Get(KSPGetPC)(ksp);
  const KSPType krylov = Get(KSPGetType)(ksp);
  const PCType type = Get(PCGetType)(pc);
  check(PCFactorGetMatSolverType(pc, &package)); // none of a type that has no factors
  return std::string(krylov ? krylov : "gmres") + " + " + (type ? type : "PETSc's choice") +
         (package ? std::string(" by ") + package : "");
}

void settle_smoothers(PC pc) {
  const char *prefix = nullptr, *option = "-pc_gamg_use_sa_esteig";
  PetscBool given = PETSC_FALSE;
  check(PCGetOptionsPrefix(pc, &prefix));
  check(PetscOptionsHasName(nullptr, prefix, option, &given));
  if (has_type(pc, PCGAMG) && !given) check(PCGAMGSetUseSAEstEig(pc, PETSC_FALSE));
}

void settle_solver(KSP ksp) {
  const char* prefix = nullptr;
  PetscBool given = PETSC_FALSE;
  int ranks = 1;
  settle_smoothers(Get(KSPGetPC)(ksp));
  MPI_Comm_size(PetscObjectComm(reinterpret_cast<PetscObject>(ksp)), &ranks);
  check(KSPGetOptionsPrefix(ksp, &prefix));
  check(PetscOptionsHasName(nullptr, prefix, "-ksp_norm_type", &given));
  if (ranks > 1 && has_type(ksp, KSPCG) && !given) check(KSPSetNormType(ksp, KSP_NORM_NATURAL));
}

void forget_factors(SNES snes) {
  const KSP ksp = Get(SNESGetKSP)(snes);
  check(KSPReset(ksp));
  // The last update, which a Krylov method may take for its first guess, and the last length of a step.
  if (const Vec update = Get(SNESGetSolutionUpdate)(snes)) check(VecSet(update, 0));
  check(SNESLineSearchSetLambda(Get(SNESGetLineSearch)(snes), 1));
  const PC pc = Get(KSPGetPC)(ksp);
  if (!has_type(pc, PCGAMG, PCFIELDSPLIT)) return;
  // The solvers of GAMG's levels outlive a reset with what they had set up: the next hierarchy is another one
  // by 1e-4 than that of a new object. A field split keeps pointers to what the reset freed.
  const std::string type = Get(PCGetType)(pc);
  check(PCSetType(pc, PCNONE));
  check(PCSetType(pc, type.c_str()));
  check(PCSetFromOptions(pc));
  settle_smoothers(pc);
}

} // namespace impact
