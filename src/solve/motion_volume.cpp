#include <cmath>
#include <impact/petsc/error.hpp>
#include <impact/solve/motion_solver.hpp>

/// Solves of bodies that hardly change their volume, (N4).
namespace impact {

namespace {

// K/G of the first stage, and what it grows by from one to the next.
constexpr double first_K_over_G = 100, most_growth = 8;

} // namespace

bool MotionSolver::has_stages() const {
  return !arc_ && motion_.soft_volume().stiffest() > 2 * first_K_over_G;
}

// Where the displacement of one iterate changes the volume by the square of its gradient, K times that is a
// pressure of many G, whose tangent leads nowhere and lets a search go a short way only. With a softer K
// Newton's method arrives; from there on K grows while pressures stay, and full steps with the pressures that
// they foretell, those of the mixed method, correct the volume.
SNESConvergedReason MotionSolver::by_stages(Vec u, PetscInt most) {
  constexpr PetscInt most_later = 15;
  SoftVolume& volume = motion_.soft_volume();
  const double growth = volume.stiffest() / first_K_over_G;
  const int later = static_cast<int>(std::ceil(std::log(growth) / std::log(most_growth)));
  const SNESLineSearch search = Get(SNESGetLineSearch)(snes_);
  const std::string usual = line_search_of(snes_);
  PetscReal rtol = 0;
  check(SNESGetTolerances(snes_, nullptr, &rtol, nullptr, nullptr, nullptr));
  begin_again(u);
  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  for (int stage = 0; stage <= later && reason >= 0; ++stage) {
    const double K_over_G =
        stage == later ? HUGE_VAL : first_K_over_G * std::pow(growth, double(stage) / later);
    if (stage == 0)
      volume.soften(K_over_G);
    else
      motion_.stiffen(u, K_over_G);
    reuse_.forget();
    hooks_.preconditioner.forget();
    if (stage == 1) check(SNESLineSearchSetType(search, SNESLINESEARCHBASIC));
    check(SNESSetTolerances(snes_, PETSC_DEFAULT, stage == later ? rtol : 1e-2, PETSC_DEFAULT, PETSC_DEFAULT,
                            PETSC_DEFAULT));
    reason = newton(u, stage == 0 ? most : most_later);
  }
  check(SNESLineSearchSetType(search, usual.c_str()));
  check(SNESSetTolerances(snes_, PETSC_DEFAULT, rtol, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  volume.reset();
  reuse_.forget();
  return reason;
}

} // namespace impact
