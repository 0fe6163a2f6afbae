#include <impact/mesh/two_level.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/factor_cost.hpp>
#include <impact/petsc/field_solver.hpp>
#include <impact/solve/motion_solver.hpp>

namespace impact {

// An iteration with MUMPS costs a third of one that factorises before (2D, 5e3 dofs). Gaps that the linear
// solves close need directions of the iterate, though: 4 iterations with full Newton, 15 without (patch
// test); and what contact alone holds has another mass in each matrix (H2). Near a limit of its load a body
// has another tangent after each step.
// Within a Krylov method the tangent is that of the iterate, and what factorises or coarsens serves on. It
// costs about 15 of its applications (MUMPS in the plane, 2.5e5 dofs: 1.8 s and 0.12 s; GAMG in space, 3e4
// dofs: 0.22 s and 0.017 s), 8 where it factorises the upper half (0.44 s and 0.07 s).
void MotionSolver::choose_reuse() {
  const KSP ksp = Get(SNESGetKSP)(snes_);
  const PC pc = Get(KSPGetPC)(ksp);
  const bool krylov = !has_type(ksp, KSPPREONLY),
             steady = !motion_.contacts().demands().closes_gaps && loose_.empty();
  const bool factors = has_type(pc, PCLU, PCCHOLESKY),
             costly = factors || has_type(pc, two_level_type, PCGAMG, PCML, PCHYPRE, PCMG);
  const double tangent = settings_.reuse_tangent, preconditioner = settings_.reuse_preconditioner;
  reuse_ = TangentReuse(tangent >= 0 ? tangent : !krylov && factors && steady && !arc_ ? 0.1 : 0);
  hooks_.preconditioner = PreconditionerReuse(!krylov                    ? 0
                                              : preconditioner >= 0      ? preconditioner
                                              : !costly || !steady       ? 0
                                              : has_type(pc, PCCHOLESKY) ? 8
                                                                         : 15);
}

void MotionSolver::forget_factors() {
  reuse_.forget();
  hooks_.preconditioner.forget();
  impact::forget_factors(snes_);
}

void MotionSolver::use_factors(bool use) {
  if (use == by_factors_) return;
  by_factors_ = use;
  SolverDefaults now = defaults_;
  if (use) now.method = LinearMethod::factors;
  check(SNESKSPSetUseEW(snes_, PETSC_FALSE));
  set_motion_solver(snes_, now, line_search(), false);
  install_hooks();
  choose_reuse();
  forget_factors();
}

bool MotionSolver::may_take_factors() const {
  const bool shell = motion_.jacobian() != motion_.matrix();
  return !by_factors_ && !shell && may_factorise(motion_.discretisation(), defaults_);
}

void MotionSolver::take_factors(const std::string& cause) {
  check(PetscPrintf(motion_.discretisation().mesh.comm(),
                    "impact: %s %s: factors take its place from here on, in restarts too\n",
                    linear_solver_text(snes_).c_str(), cause.c_str()));
  factors_.trial[0] = 1;
  use_factors(true);
}

// Iterations grow with the slenderness of a body, while its factors have few entries.
bool MotionSolver::take_longer_than_factors(PetscInt iterations) {
  constexpr PetscInt few = 200;
  if (iterations < few || !may_take_factors()) return false;
  const double products = defaults_.method == LinearMethod::multigrid ? 8 : 1; // in an iteration
  if (products_for_factors_ == 0) products_for_factors_ = products_for_factors(motion_.matrix());
  return products * static_cast<double>(iterations) > products_for_factors_;
}

// After a linear solve that failed.
bool MotionSolver::fall_back_on_factors() {
  const PetscInt stopped = hooks_.take_stopped();
  if (cell_broke_ || !may_take_factors()) return false;
  take_factors(stopped > 0
                   ? text_of("takes more than %d iterations for a linear solve, the time of a factorisation",
                             static_cast<int>(stopped))
                   : "does not solve the motion");
  return true;
}

} // namespace impact
