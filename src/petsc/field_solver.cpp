#include <algorithm>
#include <impact/petsc/error.hpp>
#include <impact/petsc/field_solver.hpp>
#include <string>

namespace impact {

void check_solver_options(const char* prefix, std::initializer_list<SNESType> types) {
  const std::string field(prefix), option = "-" + field + "snes_type";
  char type[128] = "";
  PetscBool given = PETSC_FALSE;
  PetscReal step = 0;
  check(PetscOptionsGetString(nullptr, nullptr, option.c_str(), type, sizeof(type), &given));
  if (given && std::none_of(types.begin(), types.end(), [&](SNESType t) { return std::string(t) == type; })) {
    std::string allowed;
    for (SNESType t : types) allowed += (allowed.empty() ? "" : ", ") + std::string(t);
    throw UserError(ExitCode::usage, option + " \"" + type + "\": cannot solve this problem; allowed: " +
                                         allowed + "; leave the option out");
  }
  check(PetscOptionsGetReal(nullptr, nullptr, ("-" + field + "snes_stol").c_str(), &step, &given));
  if (given && step > 0)
    throw UserError(
        ExitCode::usage,
        "-" + field +
            "snes_stol: is positive; a short step says nothing about what is left; allowed: 0; give -" +
            field + "snes_rtol or -" + field + "snes_atol");
}

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

} // namespace impact
