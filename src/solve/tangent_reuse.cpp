#include <impact/petsc/error.hpp>
#include <impact/solve/tangent_reuse.hpp>

namespace impact {

bool TangentReuse::serves(SNES snes, PetscReal dt, PetscReal shift) {
  if (reduction_ <= 0) return false;
  PetscInt iteration = 0;
  PetscReal norm = 0;
  check(SNESGetIterationNumber(snes, &iteration));
  check(SNESGetFunctionNorm(snes, &norm));
  // A solve's first iteration tries the tangent of the solve before: its reduction is known only afterwards.
  const bool reduces = iteration == 0 || norm <= reduction_ * norm_;
  const bool serves = valid_ && dt == dt_ && shift == shift_ && reduces;
  valid_ = true;
  dt_ = dt;
  shift_ = shift;
  norm_ = norm;
  return serves;
}

} // namespace impact
