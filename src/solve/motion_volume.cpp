#include <algorithm>
#include <cmath>
#include <impact/petsc/error.hpp>
#include <impact/solve/motion_solver.hpp>

/// Solves of bodies that hardly change their volume, (N4).
namespace impact {

// How many searches in a row cut a step short before a solve is given up for one in stages; 0: never. Flow
// that spreads cuts steps, too, and often arrives. Where it meets a contact or breaks that is what cuts them.
int MotionSolver::patience() const {
  constexpr double least = 2;
  const SoftVolume::Growth& growth = motion_.soft_volume().growth();
  if (arc_) return 0;
  if (growth.elastic > least) return 2;
  return growth.flowing > least && motion_.contacts().empty() ? 6 : 0;
}

SNESConvergedReason MotionSolver::first_way(Vec u, PetscInt most) {
  const int patience_for = hooks_.conduct.patience = patience();
  hooks_.conduct.hurried = false;
  SNESConvergedReason reason = newton(u, most);
  if (reason == SNES_DIVERGED_LINEAR_SOLVE && fall_back_on_factors()) {
    begin_again(u);
    reason = newton(u, most);
  }
  hooks_.conduct.patience = 0;
  if (reason > 0 || reason == SNES_DIVERGED_LINEAR_SOLVE || patience_for == 0) return reason;
  const bool hurried = hooks_.conduct.hurried, broke = cell_broke_;
  const PetscInt iterations = iterations_;
  if (const SNESConvergedReason staged = by_stages(u, most); staged > 0) return staged;
  iterations_ = iterations;
  begin_again(u);
  if (hurried) return newton(u, most);
  cell_broke_ = broke;
  return reason;
}

// Where the displacement of one iterate changes the volume by the square of its gradient, K times that is a
// pressure of many G, whose tangent leads nowhere and lets a search go a short way only. With a softer K
// Newton's method arrives; from there on K grows while pressures stay, and full steps with the pressures that
// they foretell, those of the mixed method, correct the volume.
SNESConvergedReason MotionSolver::by_stages(Vec u, PetscInt most) {
  constexpr PetscInt most_later = 15;
  constexpr double most_elastic = 8, most_flowing = 3; // growth of K from one stage to the next
  SoftVolume& volume = motion_.soft_volume();
  const auto stages = [](double growth, double at_once) {
    return static_cast<int>(std::ceil(std::log(growth) / std::log(at_once)));
  };
  const int later =
      std::max(stages(volume.growth().elastic, most_elastic), stages(volume.growth().flowing, most_flowing));
  const SNESLineSearch search = Get(SNESGetLineSearch)(snes_);
  const std::string usual = line_search_of(snes_);
  PetscReal rtol = 0;
  check(SNESGetTolerances(snes_, nullptr, &rtol, nullptr, nullptr, nullptr));
  begin_again(u);
  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  for (int stage = 0; stage <= later && reason >= 0; ++stage) {
    if (stage == 0)
      volume.soften();
    else
      motion_.stiffen(u, double(stage) / later);
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
