#include <impact/time/pass_shell.hpp>

namespace impact {

namespace {

SNESConvergedReason run_passes(SNES snes, const PassShell& shell, Vec x) {
  PetscReal atol = 0;
  PetscInt max_it = 0;
  check(SNESGetTolerances(snes, &atol, nullptr, nullptr, &max_it, nullptr));
  check(SNESSetIterationNumber(snes, 0));
  for (PetscInt pass = 1; pass <= max_it; ++pass) {
    const PassResult result = shell.pass(pass, x);
    check(SNESSetIterationNumber(snes, pass));
    if (result.inner < 0) return SNES_DIVERGED_INNER;
    check(SNESSetFunctionNorm(snes, result.change));
    check(SNESMonitor(snes, pass, result.change));
    if (result.change < atol) return SNES_CONVERGED_FNORM_ABS;
  }
  return max_it == 1 && shell.single_pass ? SNES_CONVERGED_ITS : SNES_DIVERGED_MAX_IT;
}

PetscErrorCode solve_passes(SNES snes, Vec x) {
  void* context = nullptr;
  if (const PetscErrorCode code = SNESShellGetContext(snes, &context); code != 0) return code;
  const auto& shell = *static_cast<const PassShell*>(context);
  return shell.mailbox->guarded([&] { check(SNESSetConvergedReason(snes, run_passes(snes, shell, x))); });
}

} // namespace

void make_pass_shell(SNES snes, PassShell& shell) {
  check(SNESSetType(snes, SNESSHELL));
  check(SNESShellSetContext(snes, &shell));
  check(SNESShellSetSolve(snes, solve_passes));
}

} // namespace impact
