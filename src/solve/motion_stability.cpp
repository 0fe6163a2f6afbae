#include <impact/petsc/error.hpp>
#include <impact/petsc/field_solver.hpp>
#include <impact/solve/motion_solver.hpp>
#include <impact/solve/stability.hpp>

namespace impact {

bool MotionSolver::leaves_unstable() const {
  return defaults_.has_energy && motion_.contacts().empty() && !arc_ &&
         settings_.leave_unstable != LeaveUnstable::never && can_be_factorised(motion_.discretisation().mesh);
}

// The energy falls from a saddle along its modes, and the equilibrium found there has fewer of them. A solve
// that fails leaves the one before. To which side a perfect body goes nothing tells, so that it stays unless
// asked; one that has begun to leave goes on.
void MotionSolver::leave_unstable(Vec u, PetscInt most) {
  constexpr int rounds = 10, patience = 4; // down an energy it arrives, if late
  constexpr double rounding = 1e-8;
  const bool always = settings_.leave_unstable == LeaveUnstable::always;
  const Discretisation& d = motion_.discretisation();
  const Handle<Vec> found = d.displacement.make_global(), direction = d.displacement.make_global();
  const UnstableModes first = find_unstable_modes(motion_, u, always, direction);
  UnstableModes modes = first;
  for (int round = 0; modes.number > 0 && round < rounds && (always || round > 0 || modes.part > rounding);
       ++round) {
    check(VecCopy(u, found));
    reuse_.forget();
    if (!go_down(u, direction) || newton(u, patience * most) < 0) {
      cell_broke_ = false;
      check(VecCopy(found, u));
      check(SNESComputeFunction(snes_, u, left())); // the last one is that of the solve that failed
      break;
    }
    modes = find_unstable_modes(motion_, u, true, direction);
  }
  reuse_.forget();
  if (modes.number == 0 && first.number > 0)
    check(PetscPrintf(d.mesh.comm(),
                      "impact: t = %.10g: left an equilibrium that is unstable, in which the tangent has %d "
                      "negative eigenvalue%s (-motion_leave_unstable)\n",
                      motion_.step().t, static_cast<int>(first.number), first.number == 1 ? "" : "s"));
}

// From u along the mode for as long as the energy falls.
bool MotionSolver::go_down(Vec u, Vec direction) {
  constexpr int doublings = 60;
  const Discretisation& d = motion_.discretisation();
  const Handle<Vec> r = d.displacement.make_global(), there = d.displacement.make_global();
  double length = 0, next = 1e-2 * d.mesh.smallest_edge();
  for (int looks = 0; looks < doublings; ++looks, next *= 2) {
    check(VecWAXPY(there, next, direction, u));
    check(SNESComputeFunction(snes_, there, r));
    if (cell_broke_ || Get(VecDot)(r, direction) >= 0) break;
    length = next;
  }
  cell_broke_ = false;
  check(VecAXPY(u, length, direction));
  return length > 0;
}

} // namespace impact
