#include <impact/petsc/error.hpp>
#include <impact/petsc/forget.hpp>

namespace impact {

void forget_factors(SNES snes) {
  KSP ksp = nullptr;
  check(SNESGetKSP(snes, &ksp));
  check(KSPReset(ksp));
  PC pc = nullptr;
  PetscBool gamg = PETSC_FALSE;
  check(KSPGetPC(ksp, &pc));
  check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(pc), PCGAMG, &gamg));
  if (!gamg) return;
  // The solvers of its levels outlive a reset with what they had set up: the next hierarchy is another one
  // by 1e-4 than that of a new object.
  check(PCSetType(pc, PCNONE));
  check(PCSetType(pc, PCGAMG));
  check(PCSetFromOptions(pc));
}

} // namespace impact
