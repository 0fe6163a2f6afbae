#include <impact/petsc/error.hpp>
#include <impact/solve/motion_solver.hpp>

/// What a motion solve tries where its first way goes in circles.
namespace impact {

void MotionSolver::watch(bool on) {
  hooks_.conduct.watched = on && !motion_.contacts().empty() && has_second_way();
  hooks_.conduct.follows_sliding = on;
}

// Multipliers outside Newton's method do not change its active set. Those of the iterates have mostly come
// near; with friction they may stick where it slides, or have run away: then those of the start are better.
SNESConvergedReason MotionSolver::other_ways(Vec u, PetscInt most) {
  SNESConvergedReason reason = SNES_DIVERGED_LOCAL_MIN;
  const PetscInt end = iterations_ + most;
  const auto goes_on = [&] { return reason < 0 && iterations_ < end; };
  ContactSet& contacts = motion_.contacts();
  bool near = false;
  if (contacts.fall_back()) {
    const auto left = [&] {
      begin_again(u);
      check(SNESComputeFunction(snes_, u, residual_));
      return Get(VecNorm)(residual_, NORM_2);
    };
    const auto full_steps = [&] {
      begin_again(u);
      watch(true);
      reason = newton(u, end - iterations_);
      watch(false);
    };
    const PetscReal of_iterates = left();
    contacts.swap_multipliers();
    near = of_iterates <= 2 * left();
    if (near) {
      contacts.swap_multipliers();
      full_steps();
      if (reason < 0) contacts.swap_multipliers();
    }
    if (goes_on()) full_steps();
  }
  if (goes_on()) reason = backtrack(u, end - iterations_);
  if (goes_on() && near) {
    contacts.swap_multipliers();
    reason = backtrack(u, end - iterations_);
  }
  return reason;
}

} // namespace impact
