#include <impact/petsc/error.hpp>
#include <impact/petsc/field_solver.hpp>
#include <impact/petsc/log.hpp>
#include <impact/petsc/partial_factors.hpp>
#include <impact/solve/stabilised_update.hpp>
#include <impact/time/types.hpp>

namespace impact {

namespace {

// The projection as a SNES problem: shift M (w - goal) + s R_contact(w) = 0.
struct Projection {
  MotionProblem& motion;
  double shift;
  Vec goal;
  Mailbox& letters;

  void residual(SNES, Vec w, Vec f) { motion.projection_residual(w, goal, shift, f); }
  // The mass is well conditioned by its diagonal; what presses is large beside it, and in few rows.
  void tangent(SNES snes, Vec w, Mat, Mat) {
    motion.projection_tangent(w, shift);
    factorise_rows(Get(KSPGetPC)(Get(SNESGetKSP)(snes)), motion.matrix(), motion.stiffened_rows());
  }
  Mailbox& mailbox() { return letters; }
};

// For a scope contacts are those of the projection.
class ProjectedContacts {
public:
  explicit ProjectedContacts(ContactSet& contacts) : contacts_(contacts) {
    for (ContactInterface& contact : contacts_) contact.begin_projection();
  }
  ProjectedContacts(const ProjectedContacts&) = delete;
  ProjectedContacts& operator=(const ProjectedContacts&) = delete;
  ~ProjectedContacts() {
    for (ContactInterface& contact : contacts_) contact.end_projection();
  }

private:
  ContactSet& contacts_;
};

} // namespace

StabilisedUpdate::StabilisedUpdate(TS ts, MotionProblem& motion, MotionSolver& solver, StateTable& state,
                                   bool stabilise, bool unilateral)
    : ts_(ts), motion_(motion), solver_(solver), state_(state), stabilise_(stabilise),
      unilateral_(unilateral && integrator_of(ts).inertia && !integrator_of(ts).is_explicit()),
      acceleration_(motion.discretisation().displacement.make_global()),
      told_(motion.discretisation().displacement.make_global()) {
  const Discretisation& d = motion.discretisation();
  for (Handle<Vec>* vec : {&step_.at_end, &step_.shock}) *vec = d.displacement.make_global();
  if (stabilise_ || unilateral_)
    for (Handle<Vec>* vec : {&step_.closing, &step_.over_step, &step_.hidden})
      *vec = d.displacement.make_global();
  if (unilateral)
    step_.carried = &state.add({"closing_carried", Support::vertex, d.dim()}, d.node_values(d.dim()));
}

// Of what acts over the step as a whole.
ForceShare StabilisedUpdate::share() const {
  const Integrator& p = integrator_of(ts_);
  return {p.share(), p.alpha_m, p.gamma, p.moves_by_mean_velocity() ? 1 - 1 / p.share() : 0};
}

ForceShare StabilisedUpdate::contact_share() const {
  return stabilise_ ? share() : ForceShare{.alpha_m = integrator_of(ts_).alpha_m};
}

void StabilisedUpdate::carry(Vec unilateral) {
  motion_.discretisation().displacement.to_local(unilateral, step_.carried->trial);
  step_.carried->committed = step_.carried->trial;
}

void StabilisedUpdate::correct(Vec contact_force, Vec u, Vec v, Vec a) {
  const InStage stage(Stage::motion);
  check(VecSet(acceleration_, 0));
  check(VecCopy(contact_force, step_.at_end));
  if (stabilise_ || unilateral_) split_step_forces(u, v, a);
  if (!motion_.rigid().empty()) take_out_rigidity(u, v, a);
}

// Contact and what is crushed.
void StabilisedUpdate::split_step_forces(Vec u, Vec v, Vec a) {
  for (const Vec of_step : {step_.over_step.get(), step_.hidden.get()}) check(VecSet(of_step, 0));
  // F becomes at_end, and F - Y_n is summed.
  const auto split = [&, share = share()](Vec force, Vec minus_carried) {
    check(VecAXPY(step_.over_step, 1, force));
    check(VecAXPY(step_.over_step, 1, minus_carried));
    check(VecAXPY(step_.hidden, -1, force));
    if (share.over_step == 0) check(VecAXPBY(force, share.scale - 1, share.scale, minus_carried));
    check(VecAXPY(step_.hidden, 1, force));
  };
  const FieldLayout& layout = motion_.discretisation().displacement;
  if (stabilise_) {
    const Handle<Vec> carried = layout.make_global();
    motion_.contacts().add_carried(1, carried);
    split(step_.at_end, carried);
  }
  if (unilateral_) {
    motion_.parts(u, forces_);
    layout.to_local(forces_.unilateral, step_.carried->trial);
    for (std::size_t i = 0; i < step_.carried->trial.size(); ++i)
      step_.carried->trial[i] = share().carried(step_.carried->trial[i], step_.carried->committed[i]);
    check(VecCopy(forces_.unilateral, step_.closing));
    check(VecScale(step_.closing, -1));
    split(step_.closing, motion_.discretisation().global_of(step_.carried->committed));
  }
  check(VecScale(step_.over_step, share().over_step));
  if (share().over_step != 0) take_out_over_step(v, a);
}

void StabilisedUpdate::take_out_over_step(Vec v, Vec a) {
  const PetscReal size = Get(VecNorm)(step_.over_step, NORM_INFINITY);
  if (size == 0) return;
  const Integrator& p = integrator_of(ts_);
  const Handle<Vec> scaled = motion_.discretisation().displacement.make_global();
  check(VecAXPY(scaled, 1 / (2 * p.beta), step_.over_step));
  motion_.mass_solve(scaled, acceleration_);
  check(VecAXPY(a, -1, acceleration_));
  check(VecAXPY(v, motion_.step().dt * (2 * p.beta - p.gamma), acceleration_));
  motion_.mass_multiply(acceleration_, step_.hidden);
  check(VecAYPX(step_.hidden, -2 * p.beta, step_.over_step));
}

void StabilisedUpdate::take_out_rigidity(Vec u, Vec v, Vec a) {
  // What remains of the acceleration is that by the forces.
  const Discretisation& d = motion_.discretisation();
  const Integrator& p = integrator_of(ts_);
  ForceParts forces;
  motion_.parts(u, forces);
  check(VecAXPY(forces.external, 1, step_.at_end));
  const Handle<Vec> kept = d.displacement.make_global(), taken = d.displacement.make_global(),
                    before = d.global_of(state_.row("a").committed);
  check(VecCopy(a, kept));
  motion_.rigid().accelerate(forces.external, kept);
  // a_m = alpha_m a + (1 - alpha_m) a_n is what the forces give.
  check(VecAXPBYPCZ(taken, -1 / p.alpha_m, (1 - p.alpha_m) / p.alpha_m, 0, kept, before));
  check(VecAXPY(taken, 1, a));
  motion_.rigid().keep_bodies_only(taken);
  check(VecAXPY(a, -1, taken));
  check(VecAXPY(v, motion_.step().dt * (2 * p.beta - p.gamma), taken));
  check(VecAXPY(acceleration_, 1, taken));
  // What is not free moves by its mean velocity, whatever forces do: v_n + v = 2 du/dt there.
  const Handle<Vec> lag = d.displacement.make_global(), free = d.displacement.make_global();
  check(VecAXPBYPCZ(lag, 2 * p.beta - p.gamma, p.s - 1 - 2 * p.beta + p.gamma, 0, a, before));
  check(VecCopy(lag, free));
  motion_.rigid().place(u);
  motion_.rigid().keep_free_rates(free);
  check(VecAXPY(lag, -1, free));
  check(VecAXPY(v, motion_.step().dt, lag));
  motion_.rigid().move_as_told(v, told_);
}

void StabilisedUpdate::predict(const Attempt& attempt, Vec u_tilde, Vec v) {
  const InStage stage(Stage::motion);
  const Discretisation& d = motion_.discretisation();
  check(VecSet(step_.shock, 0));
  const ProjectedContacts projected(motion_.contacts());
  RigidBodies& rigid = motion_.rigid();
  // Rigid bodies: among rigid motions, and only what contact changes counts.
  const Handle<Vec> predictor = d.displacement.make_global(), start = d.displacement.make_global();
  check(VecCopy(u_tilde, predictor));
  if (!rigid.empty()) {
    rigid.test_in_the_middle(false);
    rigid.retract(u_tilde);
  }
  check(VecCopy(u_tilde, start));
  solver_.refresh_contact(u_tilde);
  const bool strikes =
      motion_.contacts().review(u_tilde).penetration > 0 && project(attempt, predictor, u_tilde, v);
  if (!strikes) check(VecCopy(start, u_tilde));
  if (!rigid.empty()) {
    rigid.test_in_the_middle(true);
    if (!strikes) rigid.put_change(u_tilde, start, predictor);
  }
  motion_.balance().forget();
}

// Projects u_tilde; false, with u_tilde undefined, where that does not converge: without projection the step
// is still energy decaying, only less smooth.
bool StabilisedUpdate::project(const Attempt& attempt, Vec goal, Vec u_tilde, Vec v) {
  const double dt = attempt.dt;
  if (const SNESConvergedReason reason = minimise(dt, goal, u_tilde); reason < 0) {
    warn(attempt.t_n, reason);
    return false;
  }
  motion_.contacts().add_forces(u_tilde, -0.5, step_.shock);
  for (ContactInterface& contact : motion_.contacts()) contact.keep_shock(u_tilde);
  // M (w - u_tilde) = dt^2/2 times the force of the projection, beyond the tolerance of its solve.
  const FieldLayout& layout = motion_.discretisation().displacement;
  const Handle<Vec> force = layout.make_global(), gain = layout.make_global(); // gain: of v, over dt
  check(VecCopy(step_.shock, force));
  motion_.mass_solve(force, gain);
  motion_.rigid().strike(step_.shock, gain);
  check(VecAXPY(v, dt, gain));
  check(VecWAXPY(u_tilde, dt * dt, gain, goal));
  return true;
}

// Takes w to the projection of `goal`, with the contact's own enforcement.
SNESConvergedReason StabilisedUpdate::minimise(double dt, Vec goal, Vec w) {
  const Discretisation& d = motion_.discretisation();
  Projection problem{motion_, integrator_of(ts_).mass_shift(dt), goal, time_mailbox(ts_)};
  const Handle<Vec> f = d.displacement.make_global();
  Handle<SNES> snes;
  solver_.reuse().forget();
  motion_.balance().forget();
  check(SNESCreate(d.mesh.comm(), snes.out()));
  const KSP ksp = Get(SNESGetKSP)(snes);
  check(KSPSetType(ksp, KSPGMRES)); // a pressed point on a vertex makes the matrix indefinite
  check(KSPSetTolerances(ksp, 1e-10, PETSC_DEFAULT, PETSC_DEFAULT, 1000));
  check(SNESSetFunction(snes, f, Callback<&Projection::residual>::call, &problem));
  check(SNESSetJacobian(snes, motion_.jacobian(), motion_.matrix(), Callback<&Projection::tangent>::call,
                        &problem));
  check(SNESSetTolerances(snes, motion_.reference_force(), 1e-10, 0, 25, PETSC_DEFAULT));
  // Full steps: the problem is convex, and a search for a smaller residual stalls where a point opens or
  // closes.
  check(SNESLineSearchSetType(Get(SNESGetLineSearch)(snes), SNESLINESEARCHBASIC));
  NewtonHooks& hooks = solver_.hooks();
  const double cost = hooks.preconditioner.cost();
  hooks.preconditioner = PreconditionerReuse(0); // another matrix in each projection
  hooks.install(snes);
  hooks.conduct.iterate = w;
  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  for (ContactInterface& contact : motion_.contacts()) contact.start_augmentation();
  for (int pass = 0; pass < 10; ++pass) {
    check(SNESSolve(snes, nullptr, w));
    check(SNESGetConvergedReason(snes, &reason));
    if (reason <= 0) break;
    if (motion_.contacts().review(w).converged) break;
    for (ContactInterface& contact : motion_.contacts()) contact.augment(w);
  }
  hooks.install(solver_.snes());
  hooks.preconditioner = PreconditionerReuse(cost);
  return reason;
}

void StabilisedUpdate::warn(double t_n, SNESConvergedReason reason) {
  if (!warned_)
    check(PetscPrintf(motion_.discretisation().mesh.comm(),
                      "impact: the predictor of the step from t = %.10g could not be projected on the "
                      "contact (%s); it is taken as it is, here and wherever that happens again\n",
                      t_n, SNESConvergedReasons[reason]));
  warned_ = true;
}

} // namespace impact
