#include <algorithm>
#include <cmath>
#include <impact/petsc/field_solver.hpp>
#include <impact/petsc/log.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/cell_loop.hpp>
#include <impact/solve/coupling.hpp>
#include <impact/time/types.hpp>

namespace impact {

namespace {

// Whether m tau- of broken points acts like a contact. Not in sheets, whose thickness gives way: compression
// is never more than 1 + 4G/3K times as stiff as tension there.
bool has_unilateral_stress(const Fields& fields) {
  const Discretisation& d = fields.motion.discretisation();
  return fields.damage && d.frame != Frame::plane_stress &&
         std::any_of(d.materials.begin(), d.materials.end(), [](const MaterialAssignment& m) {
           return m.law.parameters.damage != Damage::none && m.law.parameters.split != Split::none;
         });
}

bool exchanges(const Discretisation& d) {
  return std::any_of(d.materials.begin(), d.materials.end(),
                     [](const MaterialAssignment& m) { return m.law.exchanges(); });
}

} // namespace

Coupling::Coupling(TS ts, const Fields& fields, const CouplingScenario& settings,
                   const SolverDefaults& defaults, bool stabilise_contact)
    : ts_(ts), fields_(fields), settings_(settings),
      last_step_(fields.state.add({"last_step", Support::global, 1}, 1)),
      solver_(ts, fields.motion, defaults, settings, fields.state), augmentation_(ts, fields.motion, solver_),
      update_(ts, fields.motion, solver_, fields.state,
              stabilise_contact && !fields.motion.contacts().empty(), has_unilateral_stress(fields)),
      phi_passes_(fields.motion.discretisation().mesh, settings_),
      limits_(settings_, integrator_of(ts).inertia),
      shell_{[this](PetscInt number, Vec u) { return pass(number, u); }, &time_mailbox(ts), true,
             [this](PetscInt passes, PetscReal change) { give_up(passes, change); }} {
  if (integrator_of(ts_).is_explicit())
    explicit_.emplace(ts_, fields_.motion, fields_.state, fields_.erosion, settings_.by_central_differences);
  if (explicit_ && fields_.damage && settings_.damage_every > 1)
    damage_wait_ = &fields_.state.add({"damage_wait", Support::global, 2}, 2);
  if (integrator_of(ts_).inertia) warming_ = fields_.state.find("warming");
  if (settings_.path_dissipation > 0) path_.emplace(fields_.state, settings_);
  const Discretisation& d = fields_.motion.discretisation();
  pass_.u = d.displacement.make_local();
  if (fields_.damage) pass_.phi = fields_.state.row("phi").committed;
  if (fields_.heat) pass_.theta = fields_.state.row("theta").committed;
  if (warming_) pass_.warming = warming_->committed;
  if (fields_.heat || exchanges(d)) pass_.dissipation.resize(d.point_values(1));
  const SNES snes = Get(TSGetSNES)(ts_);
  check(SNESSetOptionsPrefix(snes, "coupling_"));
  make_pass_shell(snes, shell_);
  check(SNESSetTolerances(snes, settings_.atol, 0, 0, settings_.max_it, PETSC_DEFAULT));
}

// What an attempt holds fixed in all its passes; phi and theta are those of the pass.
MotionStep Coupling::frozen_step() const {
  MotionStep step;
  if (fields_.damage) step.phi = &pass_.phi;
  if (fields_.heat) step.theta = &pass_.theta;
  if (warming_) step.warming = &pass_.warming;
  step.contact = update_.contact_share();
  if (explicit_) step.bulk = settings_.by_central_differences.bulk;
  step.unilateral_scale = update_.unilateral_scale();
  step.unilateral_carried = update_.unilateral_carried();
  return step;
}

// Between steps the viscous stress still wants C at an earlier time: a backward step short against everything
// else.
void Coupling::begin_between_steps(double t, Vec u, Vec v) {
  const Discretisation& d = fields_.motion.discretisation();
  const PetscReal dt = Get(TSGetTimeStep)(ts_);
  t = first_loads({.t_n = t}).t_n;
  const double h = 1e-6 * dt;
  u_before_ = d.local_of(u);
  const std::vector<double> rate = d.local_of(v);
  for (std::size_t i = 0; i < u_before_.size(); ++i) u_before_[i] -= h * rate[i];
  MotionStep step = frozen_step();
  step.t_n = t - h;
  step.t = t;
  step.dt = h;
  step.u_n = &u_before_;
  velocity_offset_ = rate;
  step.velocity_offset = &velocity_offset_;
  if (fields_.damage) step.phi = &fields_.state.row("phi").committed;
  if (fields_.heat) step.theta = &fields_.state.row("theta").committed;
  if (warming_) step.warming = &warming_->committed;
  fields_.motion.begin(step);
}

void Coupling::start(Vec u, Vec v, Vec a) {
  MotionProblem& motion = fields_.motion;
  StateTable& state = fields_.state;
  const FieldLayout& layout = motion.discretisation().displacement;
  if (fields_.heat && settings_.moves)
    if (const HeatRows rows = fields_.heat->rows(); rows.stress) {
      MotionProblem::Increments unused;
      Handle<Vec> internal; // bulk viscosity acts from the start on
      if (explicit_) internal = layout.make_global();
      motion.advance(u, unused, {nullptr, rows.stress}, explicit_ ? internal.get() : nullptr);
      state.row("stress").committed = *rows.stress;
      state.rollback();
    }
  if (fields_.damage) {
    layout.to_local(u, pass_.u);
    fields_.damage->start(pass_.u);
  }
  start_acceleration(u, v, nullptr, a);
}

void Coupling::start_acceleration(Vec u, Vec v, Vec contact, Vec a) {
  if (!integrator_of(ts_).inertia) return;
  if (explicit_) {
    explicit_->start_acceleration(u, v, contact, a);
    const std::vector<double> rate = fields_.motion.discretisation().local_of(a);
    const double half = Get(TSGetTimeStep)(ts_) / 2; // after which dashpots feel the velocity
    for (std::size_t i = 0; i < velocity_offset_.size(); ++i) velocity_offset_[i] += half * rate[i];
    return set_acceleration(ts_, a);
  }
  // M a_0 = F_ext - F_int(u_0, v_0) on the free dofs; prescribed dofs keep the rate of their data.
  MotionProblem& motion = fields_.motion;
  ForceParts forces;
  motion.parts(u, forces);
  check(VecAXPY(forces.external, -1, forces.internal));
  if (forces.unilateral) {
    check(VecAXPY(forces.external, -1, forces.unilateral));
    update_.carry(forces.unilateral);
  }
  if (contact) check(VecAXPY(forces.external, 1, contact));
  motion.discretisation().displacement.to_global(fields_.state.row("a").committed, a);
  motion.mass_solve(forces.external, a);
  motion.rigid().accelerate(forces.external, a);
  set_acceleration(ts_, a);
}

void Coupling::before_attempt(const Attempt& attempt) {
  StateTable& state = fields_.state;
  if (!explicit_ || attempt.number > 1) state.rollback();
  if (fields_.erosion != nullptr) {
    fields_.erosion->follow_rows();
    let_lost_cells_go(attempt);
  }
  counts_ = {};
  pass_.number = 0;
  failure_.clear();
  solver_.begin_attempt(attempt.number);
  augmentation_.begin_attempt();
  limits_.begin(attempt.dt);
  if (fields_.damage) {
    pass_.phi = state.row("phi").committed;
    phi_passes_.begin();
  }
  if (fields_.heat) {
    fields_.heat->begin(attempt.t_n, attempt.t);
    pass_.theta = state.row("theta").committed;
    if (warming_) pass_.warming = warming_->committed;
  }
  MotionStep step = frozen_step();
  const Attempt at = first_loads(attempt);
  if (path_) path_->begin(attempt.dt);
  step.t_n = at.t_n;
  step.t = at.t;
  step.dt = attempt.dt;
  step.u_n = &state.row("u").committed;
  step.stabilised = update_.stabilised();
  step.mass_shift = integrator_of(ts_).mass_shift(attempt.dt);
  if (fields_.motion.foundations().damps() && !explicit_) {
    step.velocity_slope = integrator_of(ts_).velocity(
        attempt.dt, {*step.u_n, state.row("v").committed, state.row("a").committed}, velocity_offset_);
    step.velocity_offset = &velocity_offset_;
  }
  fields_.motion.begin(step);
  fields_.motion.balance().forget();
}

// Shorter steps come first: what Newton's method inverts on its way may well be sound where it ends. Cells
// that still are in the way leave before the next try, which begins from t_n again.
void Coupling::let_lost_cells_go(const Attempt& attempt) {
  constexpr PetscInt cuts = 3;
  if (explicit_) return;
  if (attempt.number == 1) lost_cells_.clear();
  if (attempt.number <= cuts) return;
  if (solver_.cell_broke())
    lost_cells_.insert(lost_cells_.end(), fields_.motion.inverted().begin(), fields_.motion.inverted().end());
  fields_.erosion->remove(lost_cells_);
}

void Coupling::expose_contacts(Vec u) {
  if (explicit_) return explicit_->expose(u);
  fields_.motion.expose_contacts(u);
  solver_.forget_factors();
  solver_.refresh_matrix();
}

void Coupling::predict(const Attempt& attempt, Vec u_tilde, Vec v) {
  if (update_.stabilised()) update_.predict(attempt, u_tilde, v);
}

void Coupling::correct(Vec u, Vec v, Vec a) {
  if (explicit_) return explicit_->bodies().put_velocity(v);
  update_.correct(augmentation_.contact_force(), u, v, a);
}

void Coupling::forget_factors() {
  solver_.forget_factors();
  if (fields_.damage) fields_.damage->forget_factors();
  if (fields_.heat) fields_.heat->forget_factors();
}

void Coupling::refuse(PassResult& result, SNESConvergedReason reason, std::string cause) {
  result.inner = reason;
  failure_ = std::move(cause);
}

bool Coupling::keeps_to(StepLimits::Refusal refusal, PassResult& result) {
  if (!refusal.empty()) refuse(result, SNES_DIVERGED_INNER, std::move(refusal));
  return result.inner >= 0;
}

PassResult Coupling::pass(PetscInt number, Vec u) {
  const InStage stage(Stage::motion);
  PassResult result;
  pass_.number = number;
  if (number > 1 && fields_.damage) phi_passes_.relax(number, fields_.state.row("phi"), pass_.phi);
  if (number > 1 && fields_.heat) pass_.theta = fields_.state.row("theta").trial;
  if (number > 1 && warming_) pass_.warming = warming_->trial;
  if (settings_.moves && !explicit_ && !motion_pass(u, result)) return result;
  if (!advance_points(u, result)) return result;
  const bool follows_failure = fields_.state.find("jc_failure") != nullptr;
  if (fields_.damage || fields_.heat || follows_failure)
    fields_.motion.discretisation().displacement.to_local(u, pass_.u);
  if (follows_failure) failure_pass(result);
  if (path_ && result.inner >= 0) path_->find_power(fields_.motion, u);
  if (fields_.damage && result.inner >= 0 && damage_pass(result) && explicit_)
    explicit_->follow_damage(u, fields_.state.row("phi").trial);
  if (fields_.state.find("fatigue") && result.inner >= 0) fatigue_pass(result);
  if (fields_.heat && result.inner >= 0) heat_pass(u, result);
  if (fields_.state.find("toughness") && result.inner >= 0) toughness_pass();
  if (explicit_ && fields_.erosion != nullptr && result.inner >= 0) fields_.erosion->find_failed(u);
  return result;
}

bool Coupling::motion_pass(Vec u, PassResult& result) {
  const bool other_load = path_ && pass_.number > 1;
  if (other_load) go_to_load(fields_.motion, path_->load());
  Handle<Vec> goal;
  if (pass_.number == 1 || other_load) {
    goal = solver_.imposed(u);
    if (!keeps_to(limits_.closing(fields_.motion.contacts(), goal), result)) return false;
    if (pass_.number == 1) fields_.motion.contacts().ease(goal);
    if (!solver_.enter_step(u, goal)) {
      refuse(result, SNES_DIVERGED_LINEAR_SOLVE, "motion: no answer to the load that begins");
      return false;
    }
  }
  // Augmentations have aims of their own.
  const Aim aim = fields_.motion.contacts().empty() ? phi_passes_.aim() : Aim::balance;
  result.rough = aim != Aim::balance;
  const SNESConvergedReason reason = augmentation_.solve(u, aim);
  if (reason < 0) refuse(result, reason, augmentation_.failure());
  return reason >= 0 && (!goal || keeps_to(limits_.turning(fields_.motion.rigid(), goal, u), result));
}

// Plastic flow and what drives damage and heat, at the points.
bool Coupling::advance_points(Vec u, PassResult& result) {
  HeatRows rows = fields_.heat ? fields_.heat->rows() : HeatRows{};
  if (!pass_.dissipation.empty()) rows.dissipation = &pass_.dissipation;
  std::fill(pass_.dissipation.begin(), pass_.dissipation.end(), 0.0);
  const bool changes = settings_.moves || fields_.damage;
  if (explicit_) {
    if (!explicit_->take(u, pass_.increments, rows)) {
      refuse(result, SNES_DIVERGED_FUNCTION_DOMAIN, fields_.motion.broken_text());
      return false;
    }
  } else if (changes && !fields_.motion.advance(u, pass_.increments, rows)) {
    refuse(result, SNES_DIVERGED_FUNCTION_DOMAIN, "the law failed at the solution");
    return false;
  }
  const Discretisation& d = fields_.motion.discretisation();
  return keeps_to(limits_.plastic_strain(d.mesh.comm(), d.frame, fields_.state.row("history")), result);
}

bool Coupling::damage_pass(PassResult& result) {
  const InStage stage(Stage::damage);
  StateRow& phi = fields_.state.row("phi");
  const MotionStep& step = fields_.motion.step();
  phi.trial = pass_.phi;
  double dt = step.dt;
  if (damage_wait_ != nullptr) {
    double* const wait = damage_wait_->trial.data(); // steps, time
    dt = wait[1] = damage_wait_->committed[1] + step.dt;
    if (++wait[0] < settings_.damage_every) {
      fields_.damage->rest();
      return false;
    }
    wait[0] = wait[1] = 0;
  }
  const DamageStep solved{.t = step.t, .dt = dt, .u = &pass_.u, .u_n = step.u_n, .phi_n = &phi.committed};
  const ScalarOutcome outcome =
      path_ ? path_->solve(*fields_.damage, solved, phi.trial) : fields_.damage->solve(solved, phi.trial);
  counts_.damage += outcome.newton;
  counts_.damage_linear += outcome.linear;
  if (outcome.reason < 0) {
    refuse(result, outcome.reason, std::string("damage: ") + SNESConvergedReasons[outcome.reason]);
    return false;
  }
  for (std::size_t i = 0; i < pass_.dissipation.size(); ++i)
    pass_.dissipation[i] += fields_.damage->dissipated()[i];
  const PhiPasses::Change change = phi_passes_.note(pass_.phi, phi);
  result.inner = outcome.reason;
  const double of_load = path_ ? path_->change() : 0;
  result.change = std::max<PetscReal>(change.of_pass, of_load);
  result.counts = !(settings_.follow_cracks && change.gained);
  pass_.changing = of_load > change.of_pass ? "the load parameter" : "phi";
  phi_passes_.report(pass_.number, phi);
  return keeps_to(limits_.damage(change.growth), result);
}

void Coupling::failure_pass(PassResult& result) {
  const FailureStep step{fields_.motion.step().dt, &pass_.u, fields_.damage ? &pass_.phi : nullptr,
                         fields_.heat ? &pass_.theta : nullptr};
  if (!grow_failure(fields_.motion.discretisation(), fields_.state, step))
    refuse(result, SNES_DIVERGED_FUNCTION_DOMAIN, "failure: its measure is not finite");
}

void Coupling::fatigue_pass(PassResult& result) {
  const MotionStep& step = fields_.motion.step();
  FatigueStep fatigue{step.dt, &pass_.u, step.u_n, &fields_.state.row("phi").trial};
  if (fields_.heat) {
    fatigue.theta = &pass_.theta;
    fatigue.theta_n = &fields_.state.row("theta").committed;
  }
  fatigue.phi_n = &fields_.state.row("phi").committed;
  if (!pass_.dissipation.empty()) fatigue.dissipation = &pass_.dissipation;
  fatigue_ = grow_fatigue(fields_.motion.discretisation(), fields_.state, fatigue);
  if (!fatigue_.sound) refuse(result, SNES_DIVERGED_FUNCTION_DOMAIN, "fatigue: its growth is not finite");
}

void Coupling::toughness_pass() {
  const MotionStep& step = fields_.motion.step();
  follow_toughness(fields_.motion.discretisation(), fields_.state, step.dt, pass_.u, *step.u_n);
}

void Coupling::heat_pass(Vec u, PassResult& result) {
  const InStage stage(Stage::heat);
  StateRow& theta = fields_.state.row("theta");
  HeatStep step;
  if (settings_.moves) {
    step.u = &pass_.u;
    step.u_n = fields_.motion.step().u_n;
  }
  step.displacement = u;
  if (fields_.damage) {
    step.phi = &fields_.state.row("phi").trial;
    step.phi_n = &fields_.state.row("phi").committed;
  }
  if (!pass_.dissipation.empty()) step.dissipation = &pass_.dissipation;
  step.points_keep_heat = warming_ != nullptr;
  const ScalarOutcome outcome = fields_.heat->solve(step, theta.trial);
  counts_.heat += outcome.newton;
  counts_.heat_linear += outcome.linear;
  if (outcome.reason < 0) {
    std::string cause = outcome.cause.empty() ? SNESConvergedReasons[outcome.reason] : outcome.cause;
    if (outcome.cause.empty() && outcome.reason == SNES_DIVERGED_FUNCTION_DOMAIN)
      cause += " (0 K or less at a point of a cell, or values that are no numbers)";
    return refuse(result, outcome.reason, "heat: " + cause);
  }
  const MPI_Comm comm = fields_.motion.discretisation().mesh.comm();
  result.inner = outcome.reason;
  keeps_to(limits_.temperature(comm, theta), result);
  // What no equation reads needs no second pass.
  if (fields_.motion.discretisation().temperature_moves()) compare_temperatures(theta, result);
}

// Relative to the temperature: a ten-thousandth of it strains a metal by less than 1e-6.
void Coupling::compare_temperatures(const StateRow& theta, PassResult& result) {
  double change_and_size[2] = {0, 0};
  for (std::size_t i = 0; i < theta.trial.size(); ++i) {
    change_and_size[0] = std::max(change_and_size[0], std::abs(theta.trial[i] - pass_.theta[i]));
    change_and_size[1] = std::max(change_and_size[1], theta.trial[i]);
  }
  max_over_ranks(fields_.motion.discretisation().mesh.comm(), change_and_size);
  // The shell compares with the tolerance of phi.
  const PetscReal change = change_and_size[0] / change_and_size[1],
                  scale = settings_.theta_tol > 0 ? settings_.atol / settings_.theta_tol : 1;
  if (scale * change <= result.change) return;
  result.change = scale * change;
  pass_.changing = "the temperature";
}

} // namespace impact
