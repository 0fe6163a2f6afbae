#include "step_data.hpp"
#include <string>

namespace impact::detail {

namespace {

void check_range(const char* option, PetscReal value, bool allowed, const char* range, const char* remedy) {
  if (!allowed)
    throw UserError(ExitCode::usage, std::string(option) + ": " + std::to_string(value) +
                                         "; allowed: " + range + "; " + remedy);
}

} // namespace

void check_newmark(const Integrator& p) {
  check_range("-ts_newmark_beta", p.beta, p.beta > 0 && p.beta <= 1, "0 < beta <= 1", "leave it out for 1/4");
  check_range("-ts_newmark_gamma", p.gamma, p.gamma >= 0.5 && p.gamma <= 2,
              "1/2 <= gamma <= 2, stable from 1/2 on", "leave it out for 1/2");
}

void read_newmark_options(StepData& self, OptionItems PetscOptionsObject) {
  Integrator& p = self.integrator;
  PetscReal rho = 1;
  PetscBool beta = PETSC_FALSE, gamma = PETSC_FALSE, radius = PETSC_FALSE;
  check(PetscOptionsReal("-ts_newmark_beta", "Newmark's beta", nullptr, p.beta, &p.beta, &beta));
  check(PetscOptionsReal("-ts_newmark_gamma", "Newmark's gamma", nullptr, p.gamma, &p.gamma, &gamma));
  check(PetscOptionsReal("-ts_newmark_rho", "Spectral radius at infinite frequency", nullptr, rho, &rho,
                         &radius));
  const char* const guesses[] = {"previous", "extrapolated"};
  PetscInt guess = self.extrapolate ? 1 : 0;
  check(PetscOptionsEList("-ts_newmark_guess", "Start of the nonlinear solve", nullptr, guesses, 2,
                          guesses[guess], &guess, nullptr));
  self.extrapolate = guess == 1;
  if (radius) {
    check_range("-ts_newmark_rho", rho, rho >= 0 && rho <= 1, "0 <= rho <= 1", "1 damps nothing, 0 most");
    check_range("-ts_newmark_rho", rho, !beta && !gamma,
                "not together with -ts_newmark_beta or -ts_newmark_gamma", "give one or the other");
    p = newmark_with_radius(rho);
  }
  check_newmark(p);
}

} // namespace impact::detail
