#include <algorithm>
#include <cmath>
#include <impact/petsc/error.hpp>
#include <impact/petsc/log.hpp>
#include <impact/problem/coupling.hpp>
#include <impact/time/types.hpp>

/// The contact-stabilised update of Newmark's rule (Deuflhard, Krause, Ertel 2008; src/theory.md, 7): the
/// velocity is projected on what contact admits, and forces of contact and of closing cracks act over the
/// step as a whole, a_{n+1} -= a_c, v_{n+1} += dt (2 beta - gamma) a_c with M a_c = F/(2 beta).
namespace impact {

namespace {

// The projection of a predictor as a SNES problem.
struct Projection {
  MotionProblem* motion;
  double shift;
  Vec goal;
  Mailbox* mailbox;
  static PetscErrorCode residual(SNES, Vec w, Vec f, void* context) {
    auto& self = *static_cast<Projection*>(context);
    return self.mailbox->guarded([&] { self.motion->projection_residual(w, self.goal, self.shift, f); });
  }
  static PetscErrorCode tangent(SNES, Vec w, Mat, Mat, void* context) {
    auto& self = *static_cast<Projection*>(context);
    return self.mailbox->guarded([&] { self.motion->projection_tangent(w, self.shift); });
  }
};

} // namespace

NewmarkHooks Coupling::newmark_hooks() {
  NewmarkHooks hooks;
  if (stabilise_)
    hooks.predict = [this](TS, PetscReal t_n, PetscReal dt, Vec u_tilde, Vec v) {
      const InStage stage(Stage::motion);
      project_predictor(t_n, dt, u_tilde, v);
    };
  if (stabilise_ || unilateral_ || !motion_.rigid().empty())
    hooks.correct = [this](TS, Vec u, Vec v, Vec a) {
      const InStage stage(Stage::motion);
      check(VecSet(contact_acceleration_, 0));
      if (stabilise_ || unilateral_) take_out_step_forces(u, v, a);
      if (!motion_.rigid().empty()) take_out_rigidity(u, v, a);
    };
  return hooks;
}

// The forces that act over the step as a whole: of contact, and of what is crushed.
void Coupling::take_out_step_forces(Vec u, Vec v, Vec a) {
  PetscReal size = 0;
  check(VecSet(residual_, 0));
  if (stabilise_) check(VecCopy(contact_force_, residual_));
  if (unilateral_) {
    motion_.parts(u, forces_);
    check(VecAXPY(residual_, -1, forces_.unilateral));
  }
  check(VecNorm(residual_, NORM_INFINITY, &size));
  if (size == 0) return;
  const NewmarkParameters p = newmark_parameters(ts_);
  check(VecScale(residual_, 1 / (2 * p.beta)));
  motion_.mass_solve(residual_, contact_acceleration_);
  check(VecAXPY(a, -1, contact_acceleration_));
  check(VecAXPY(v, step_.dt * (2 * p.beta - p.gamma), contact_acceleration_));
}

void Coupling::take_out_rigidity(Vec u, Vec v, Vec a) {
  // What remains of the acceleration is that by the forces, the contact's only where it is not stabilised.
  const Discretisation& d = motion_.discretisation();
  const NewmarkParameters p = newmark_parameters(ts_);
  ForceParts forces;
  motion_.parts(u, forces);
  if (!stabilise_) check(VecAXPY(forces.external, 1, contact_force_));
  Handle<Vec> kept = d.displacement.make_global(), before = d.displacement.make_global(),
              taken = d.displacement.make_global();
  check(VecCopy(a, kept));
  motion_.rigid().accelerate(forces.external, kept);
  d.displacement.to_global(state_.row("a").committed, before);
  // a_m = alpha_m a + (1 - alpha_m) a_n is what the forces give.
  check(VecAXPBYPCZ(taken, -1 / p.alpha_m, (1 - p.alpha_m) / p.alpha_m, 0, kept, before));
  check(VecAXPY(taken, 1, a));
  motion_.rigid().keep_bodies_only(taken);
  check(VecAXPY(a, -1, taken));
  check(VecAXPY(v, step_.dt * (2 * p.beta - p.gamma), taken));
  check(VecAXPY(contact_acceleration_, 1, taken));
}

void Coupling::project_predictor(double t_n, double dt, Vec u_tilde, Vec v) {
  // min 1/2 |w - u_tilde|_M over the w that the gradients of the start admit, with the contact's own
  // enforcement and multipliers from zero: dt times a change of the velocity.
  check(VecSet(contact_shock_, 0));
  motion_.contacts().begin_projection();
  // Rigid bodies: among rigid motions, and only what contact changes counts.
  bool projected = false;
  RigidBodies& rigid = motion_.rigid();
  Handle<Vec> predictor, untouched;
  if (!rigid.empty()) {
    predictor = motion_.discretisation().displacement.make_global();
    untouched = motion_.discretisation().displacement.make_global();
    check(VecCopy(u_tilde, predictor));
    rigid.test_in_the_middle(false);
    rigid.retract(u_tilde);
    check(VecCopy(u_tilde, untouched));
  }
  refresh_contact(u_tilde);
  if (motion_.contacts().review(u_tilde).penetration > 0) {
    const NewmarkParameters p = newmark_parameters(ts_);
    Projection problem{&motion_, p.alpha_m / (p.beta * dt * dt), nullptr, &time_mailbox(ts_)};
    Handle<Vec> goal = motion_.discretisation().displacement.make_global(),
                f = motion_.discretisation().displacement.make_global();
    check(VecCopy(predictor ? predictor.get() : u_tilde, goal));
    problem.goal = goal;
    Handle<SNES> snes;
    reuse_.forget();
    motion_.balance().forget();
    check(SNESCreate(motion_.discretisation().mesh.comm(), snes.out()));
    check(SNESSetKSP(snes, projection_solver()));
    check(SNESSetFunction(snes, f, Projection::residual, &problem));
    check(SNESSetJacobian(snes, motion_.jacobian(), motion_.matrix(), Projection::tangent, &problem));
    check(SNESSetTolerances(snes, motion_.reference_force(), 1e-10, 0, 25, PETSC_DEFAULT));
    // Full steps: the problem is convex, and a search for a smaller residual stalls where a point opens or
    // closes.
    SNESLineSearch search = nullptr;
    check(SNESGetLineSearch(snes, &search));
    check(SNESLineSearchSetType(search, SNESLINESEARCHBASIC));
    update_multipliers_in(snes);
    iterate_ = u_tilde;
    motion_.contacts().start_augmentation();
    for (int pass = 0; pass < 10; ++pass) {
      check(SNESSolve(snes, nullptr, u_tilde));
      SNESConvergedReason why = SNES_CONVERGED_ITERATING;
      check(SNESGetConvergedReason(snes, &why));
      if (why <= 0 || motion_.contacts().review(u_tilde).converged) break;
      motion_.contacts().augment(u_tilde);
    }
    SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
    check(SNESGetConvergedReason(snes, &reason));
    if (reason < 0) {
      // Without projection the step is still energy decaying, only less smooth.
      check(VecCopy(untouched ? untouched.get() : goal.get(), u_tilde));
      if (!projection_failed_)
        check(PetscPrintf(motion_.discretisation().mesh.comm(),
                          "impact: the predictor of the step from t = %.10g could not be projected on the "
                          "contact (%s); it is taken as it is, here and wherever that happens again\n",
                          t_n, SNESConvergedReasons[reason]));
      projection_failed_ = true;
    } else {
      motion_.contacts().keep_shock(u_tilde, contact_shock_);
      // M (w - u_tilde) = dt^2/2 times the force of the projection, beyond the tolerance of its solve.
      const Handle<Vec> gain = motion_.discretisation().displacement.make_global(); // of v, over dt
      check(VecCopy(contact_shock_, f));
      motion_.mass_solve(f, gain);
      rigid.strike(contact_shock_, gain);
      check(VecAXPY(v, dt, gain));
      check(VecWAXPY(u_tilde, dt * dt, gain, goal));
      projected = true;
    }
  }
  if (!rigid.empty()) {
    rigid.test_in_the_middle(true);
    if (!projected) rigid.put_change(u_tilde, untouched, predictor);
  }
  motion_.balance().forget();
  motion_.contacts().end_projection();
}

KSP Coupling::projection_solver() {
  // The motion's own solver, unless that needs a definite matrix: a pressed point on a vertex makes it
  // indefinite.
  KSP ksp = nullptr;
  PetscBool definite = PETSC_FALSE;
  check(SNESGetKSP(motion_snes_, &ksp));
  check(PetscObjectTypeCompareAny(reinterpret_cast<PetscObject>(ksp), &definite, KSPCG, KSPMINRES, ""));
  if (!definite) return ksp;
  if (!projection_ksp_) {
    PC pc = nullptr;
    check(KSPCreate(motion_.discretisation().mesh.comm(), projection_ksp_.out()));
    check(KSPSetType(projection_ksp_, KSPGMRES));
    check(KSPSetTolerances(projection_ksp_, 1e-10, PETSC_DEFAULT, PETSC_DEFAULT, 1000));
    check(KSPGetPC(projection_ksp_, &pc));
    check(PCSetType(pc, PCJACOBI)); // mass and a few penalties: well conditioned by its diagonal
  }
  return projection_ksp_;
}

} // namespace impact
