#include <impact/time/pass_shell.hpp>

namespace impact {

namespace {

SNESConvergedReason run_passes(SNES snes, const PassShell& shell, Vec x) {
  PetscReal atol = 0;
  PetscInt max_it = 0;
  check(SNESGetTolerances(snes, &atol, nullptr, nullptr, &max_it, nullptr));
  check(SNESSetIterationNumber(snes, 0));
  PetscInt counted = 0;
  PassResult result;
  const auto ends_roughly = [&] { return result.rough && result.change < atol; };
  for (PetscInt pass = 1; counted < max_it || ends_roughly(); ++pass) {
    result = shell.pass(pass, x);
    check(SNESSetIterationNumber(snes, pass));
    if (result.inner < 0) return SNES_DIVERGED_INNER;
    check(SNESSetFunctionNorm(snes, result.change));
    check(SNESMonitor(snes, pass, result.change));
    if (result.change < atol && !result.rough) return SNES_CONVERGED_FNORM_ABS;
    counted = result.counts ? counted + 1 : 0;
  }
  if (max_it == 1 && shell.single_pass) return SNES_CONVERGED_ITS;
  if (shell.gives_up) shell.gives_up(counted, result.change);
  return SNES_DIVERGED_MAX_IT;
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
