#include <impact/petsc/error.hpp>
#include <impact/solve/motion_solver.hpp>

/// What a motion solve tries where its first way goes in circles.
namespace impact {

// Multipliers outside Newton's method do not change its active set: those of the iterates or those of the
// start, whichever leave less there.
bool MotionSolver::fall_back(Vec u) {
  const auto left = [&] {
    begin_again(u);
    check(SNESComputeFunction(snes_, u, residual_));
    return Get(VecNorm)(residual_, NORM_2);
  };
  ContactSet& contacts = motion_.contacts();
  if (!contacts.fall_back()) return false;
  const PetscReal of_iterates = left();
  contacts.swap_multipliers();
  if (of_iterates <= left()) contacts.swap_multipliers();
  begin_again(u);
  return true;
}

} // namespace impact
