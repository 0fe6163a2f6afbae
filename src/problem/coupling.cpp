#include <algorithm>
#include <cmath>
#include <cstdio>
#include <impact/petsc/error.hpp>
#include <impact/petsc/field_solver.hpp>
#include <impact/petsc/forget.hpp>
#include <impact/petsc/log.hpp>
#include <impact/problem/cell_loop.hpp>
#include <impact/problem/coupling.hpp>
#include <impact/time/types.hpp>

namespace impact {

namespace {

// Whether m tau- of broken points acts like a contact. Not in sheets, whose thickness gives way: compression
// is never more than 1 + 4G/3K times as stiff as tension there.
bool has_unilateral_stress(const Discretisation& d) {
  return d.frame != Frame::plane_stress &&
         std::any_of(d.materials.begin(), d.materials.end(), [](const MaterialAssignment& m) {
           return m.law.parameters.damage != Damage::none && m.law.parameters.split != Split::none;
         });
}

} // namespace

Coupling::Coupling(TS ts, MotionProblem& motion, DamageProblem* damage, HeatProblem* heat, StateTable& state,
                   const CouplingScenario& settings, const SolverDefaults& defaults, bool inertia,
                   bool stabilise_contact)
    : ts_(ts), motion_(motion), damage_(damage), heat_(heat), state_(state), settings_(settings),
      phi_passes_(motion.discretisation().mesh, settings.relaxation, settings.atol, settings.follow_cracks),
      inertia_(inertia), stabilise_(stabilise_contact && inertia && !motion.contacts().empty()),
      unilateral_(inertia && damage && has_unilateral_stress(motion.discretisation())) {
  const Discretisation& d = motion_.discretisation();
  const MPI_Comm comm = d.mesh.comm();
  residual_ = d.displacement.make_global();
  left_ = d.displacement.make_global();
  contact_force_ = d.displacement.make_global();
  contact_shock_ = d.displacement.make_global();
  bare_residual_ = d.displacement.make_global();
  newton_start_ = d.displacement.make_global();
  contact_acceleration_ = d.displacement.make_global();
  u_local_ = d.displacement.make_local();
  if (!inertia_) loose_ = LooseBodies(d, motion_.boundary(), motion_.contacts(), motion_.rigid());
  if (damage_) phi_frozen_ = state_.row("phi").committed;
  if (heat_) theta_frozen_ = state_.row("theta").committed;
  const bool exchanges = std::any_of(d.materials.begin(), d.materials.end(),
                                     [](const MaterialAssignment& m) { return m.law.exchanges(); });
  if (heat_ || exchanges) dissipation_.resize(point_offsets(d.groups, 1).back());
  if (state_.find("fatigue")) fatigue_.emplace(d, state_);

  check(TSSetI2Function(
      ts_, nullptr,
      [](TS, PetscReal, Vec u, Vec, Vec a, Vec f, void* context) {
        auto& self = *static_cast<Coupling*>(context);
        return time_mailbox(self.ts_).guarded([&] {
          if (self.motion_.residual(u, self.inertia_ ? a : nullptr, f)) return;
          self.cell_broke_ = true;
          check(SNESSetFunctionDomainError(self.motion_snes_));
        });
      },
      this));
  check(TSSetI2Jacobian(
      ts_, motion_.jacobian(), motion_.matrix(),
      [](TS, PetscReal, Vec u, Vec, Vec, PetscReal, PetscReal shift_a, Mat, Mat, void* context) {
        auto& self = *static_cast<Coupling*>(context);
        return time_mailbox(self.ts_).guarded([&] {
          if (!self.loose_.empty()) {
            Vec r = nullptr;
            check(SNESGetFunction(self.motion_snes_, &r, nullptr, nullptr));
            self.loose_.weigh(u, r);
            if (self.loose_.unbalanced()) self.reuse_.forget();
          }
          if (self.reuse_.serves(self.motion_snes_, self.step_.dt, shift_a)) return;
          self.tangents_ += 1;
          const bool sound = self.motion_.tangent(u, self.inertia_ ? shift_a : 0);
          if (!self.loose_.empty()) self.loose_.add_to(self.motion_.matrix());
          if (sound) return;
          self.reuse_.forget();
          self.cell_broke_ = true;
          check(SNESSetJacobianDomainError(self.motion_snes_));
        });
      },
      this));

  check(SNESCreate(comm, motion_snes_.out()));
  check(SNESSetOptionsPrefix(motion_snes_, "motion_"));
  check(SNESSetFunction(motion_snes_, residual_, SNESTSFormFunction, ts_));
  refresh_matrix();
  check(SNESSetTolerances(motion_snes_, motion_.reference_force(), 1e-10, 0, 25, PETSC_DEFAULT));
  KSP ksp = nullptr;
  PC pc = nullptr;
  check(SNESGetKSP(motion_snes_, &ksp));
  check(KSPGetPC(ksp, &pc));
  set_solver_defaults(ksp, defaults);
  const bool shell = motion_.jacobian() != motion_.matrix();
  if (shell) {
    // The preconditioner sees the bulk alone: a direct "solve" with it would solve the wrong system, and
    // GAMG's smoothers must not take the shell for their matrix.
    if (defaults.direct) check(KSPSetTolerances(ksp, 1e-10, PETSC_DEFAULT, PETSC_DEFAULT, 1000));
    check(KSPSetType(ksp, KSPGMRES));
    check(PCSetUseAmat(pc, PETSC_FALSE));
  }
  // Secant search for the smallest residual norm along the step. Backtracking stalls where the volume is
  // stiff (Cook's membrane, nu 0.4999: no convergence in 25 iterations, against 4), the search for a zero of
  // the energy's slope where a crack opens.
  SNESLineSearch search = nullptr;
  check(SNESGetLineSearch(motion_snes_, &search));
  // With multipliers among the unknowns the full step is what makes the chosen set of gaps vanish.
  check(SNESLineSearchSetType(search, semismooth() || frictional() || !loose_.empty() ? SNESLINESEARCHBASIC
                                                                                      : SNESLINESEARCHL2));
  check(SNESSetFromOptions(motion_snes_));
  check_preconditioner(ksp, defaults.matrix);
  check(SNESGetTolerances(motion_snes_, nullptr, &residual_rtol_, nullptr, nullptr, nullptr));
  update_multipliers_in(motion_snes_);
  PetscBool factorises = PETSC_FALSE;
  check(PetscObjectTypeCompareAny(reinterpret_cast<PetscObject>(pc), &factorises, PCLU, PCCHOLESKY, ""));
  // An iteration with MUMPS costs a third of one that factorises before (2D, 5e3 dofs). Gaps that the linear
  // solves close need directions of the iterate, though: 4 iterations with full Newton, 15 without (patch
  // test); and what contact alone holds has another mass in each matrix (H2).
  if (settings_.reuse >= 0)
    reuse_ = TangentReuse(settings_.reuse);
  else if (factorises && !semismooth() && loose_.empty())
    reuse_ = TangentReuse(0.1);
  PetscBool preonly = PETSC_FALSE;
  check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(ksp), KSPPREONLY, &preonly));
  if (shell && preonly)
    throw UserError(ExitCode::usage,
                    "-motion_ksp_type preonly: not with -contact_operator shell, whose preconditioner "
                    "does not see the contact; use gmres, or -contact_operator assembled");

  uzawa_shell_ = {[this](PetscInt pass, Vec u) { return uzawa_pass(pass, u); }, &time_mailbox(ts_), false};
  check(SNESCreate(comm, uzawa_snes_.out()));
  check(SNESSetOptionsPrefix(uzawa_snes_, "uzawa_"));
  make_pass_shell(uzawa_snes_, uzawa_shell_);
  // The tolerances of gap and pressure belong to each contact: a pass changes 1 until all of them are met.
  check(SNESSetTolerances(uzawa_snes_, 0.5, 0, 0, 30, PETSC_DEFAULT));
  check(SNESSetFromOptions(uzawa_snes_));

  SNES coupling = nullptr;
  coupling_shell_ = {
      [this](PetscInt pass, Vec u) { return coupling_pass(pass, u); }, &time_mailbox(ts_), true,
      [this](PetscInt passes, PetscReal change) {
        char text[160];
        std::snprintf(text, sizeof(text), "%d passes%s, %s still changes by %.2g (-coupling_snes_max_it)",
                      static_cast<int>(passes), settings_.follow_cracks ? " in which phi does not grow" : "",
                      changing_, change);
        failure_ = text;
      }};
  check(TSGetSNES(ts_, &coupling));
  check(SNESSetOptionsPrefix(coupling, "coupling_"));
  make_pass_shell(coupling, coupling_shell_);
  check(SNESSetTolerances(coupling, settings_.atol, 0, 0, settings_.max_it, PETSC_DEFAULT));
}

void Coupling::refresh_matrix() {
  reuse_.forget();
  check(SNESSetJacobian(motion_snes_, motion_.jacobian(), motion_.matrix(), SNESTSFormJacobian, ts_));
}

void Coupling::read_contact_scale() {
  // The integrator reads its options after this object exists.
  if (!stabilise_ && !unilateral_) return;
  const NewmarkParameters p = newmark_parameters(ts_);
  const double scale = p.alpha_m / (2 * p.beta);
  if (stabilise_) contact_scale_ = scale;
  if (unilateral_) unilateral_scale_ = scale;
}

void Coupling::before_attempt(const Attempt& attempt) {
  state_.rollback();
  const PetscInt longest = attempt.number > 1 ? counts_.longest : 0;
  counts_ = {};
  counts_.longest = longest;
  if (attempt.number <= 1) second_way_first_ = false;
  hardest_solve_ = 0;
  utilisation_ = 0;
  // A step must not know which one came before: a resumed run has no factors from there.
  reuse_.forget();
  failure_.clear();
  cell_broke_ = false;
  read_contact_scale();
  step_ = {};
  step_.t_n = attempt.t_n;
  step_.t = attempt.t;
  step_.dt = attempt.dt;
  step_.u_n = &state_.row("u").committed;
  step_.contact_scale = contact_scale_;
  step_.unilateral_scale = unilateral_scale_;
  step_.stabilised = stabilise_;
  if (inertia_) {
    const NewmarkParameters p = newmark_parameters(ts_);
    step_.mass_shift = p.alpha_m / (p.beta * attempt.dt * attempt.dt);
  }
  if (damage_) {
    phi_frozen_ = state_.row("phi").committed;
    phi_passes_.begin(state_.row("phi"));
    said_ = MPI_Wtime();
    step_.phi = &phi_frozen_;
  }
  if (heat_) {
    heat_->begin(attempt.t_n, attempt.t);
    theta_frozen_ = state_.row("theta").committed;
    step_.theta = &theta_frozen_;
  }
  motion_.begin(step_);
  motion_.balance().forget();
  loose_.start_attempt();
}

void Coupling::guess(const Attempt& attempt, Vec u) {
  // The last increment, scaled: prescribed nodes do not jump ahead of their neighbours, and unlike dt v_n it
  // does not follow the alternation of v that an undamped integrator keeps at frequencies far above 1/dt.
  std::vector<double> local = state_.row("u").committed;
  const std::vector<double>& rate = state_.row("mean_rate").committed;
  for (std::size_t i = 0; i < local.size(); ++i) local[i] += attempt.dt * rate[i];
  motion_.discretisation().displacement.to_global(local, u);
}

void Coupling::on_reject() { state_.rollback(); }

void Coupling::forget_factors() {
  impact::forget_factors(motion_snes_);
  if (damage_) damage_->forget_factors();
  if (heat_) heat_->forget_factors();
}

std::span<const double> Coupling::heat_supplied() const {
  return heat_ ? std::span<const double>(heat_->supplied()) : std::span<const double>();
}

bool Coupling::refresh_contact(Vec u) {
  if (!motion_.update_contact(u)) return false;
  // Another pattern: a new matrix, and the solver's factors with it.
  impact::forget_factors(motion_snes_);
  refresh_matrix();
  check(TSSetI2Jacobian(ts_, motion_.jacobian(), motion_.matrix(), nullptr, nullptr));
  return true;
}

// Multipliers of the semismooth method follow every iterate, before the residual is evaluated there; the
// solve ends when they have come to rest too.
PassResult Coupling::uzawa_pass(PetscInt pass, Vec u) {
  PassResult result;
  refresh_contact(u);
  if (!loose_.empty()) approach(u);
  // What presses nothing yet is brought to rest on penalties, roughly: their forces grow with the way, and
  // the semismooth method, whose gaps close at once, begins from the pressures that they find.
  if (pass == 1) first_touch_ = (semismooth() || augments()) && !loose_.empty() && !loose_.rest(u);
  motion_.contacts().meet(!loose_.empty(), first_touch_);
  motion_.contacts().start_newton(u);
  // Before the last augmentation a residual that falls to a tenth is exact enough.
  rough_ = first_touch_ || (pass > 1 && rough_);
  constexpr PetscInt enough = 10; // for a first touch, or it has the wrong way
  PetscReal rtol = 0;
  PetscInt most = 0;
  check(SNESGetTolerances(motion_snes_, nullptr, &rtol, nullptr, &most, nullptr));
  const auto solve_to = [&](PetscReal relative) {
    check(SNESSetTolerances(motion_snes_, PETSC_DEFAULT, relative, PETSC_DEFAULT,
                            first_touch_ ? std::min(most, enough) : most, PETSC_DEFAULT));
    return solve_motion(u);
  };
  const auto settled = [&] { return motion_.contacts().review(u).converged; };
  result.inner = solve_to(rough_ ? std::max(rtol, 0.1) : rtol);
  if (first_touch_ && result.inner < 0) {
    first_touch_ = rough_ = cell_broke_ = false;
    loose_.start_attempt();
    check(VecCopy(newton_start_, u));
    motion_.contacts().meet(!loose_.empty(), false);
    motion_.contacts().start_newton(u);
    result.inner = solve_to(rtol);
  }
  if (rough_ && result.inner >= 0 && !first_touch_ && settled()) {
    rough_ = false;
    result.inner = solve_to(rtol);
  }
  check(SNESSetTolerances(motion_snes_, PETSC_DEFAULT, rtol, PETSC_DEFAULT, most, PETSC_DEFAULT));
  counts_.uzawa += 1;
  if (result.inner < 0) {
    failure_ = std::string("motion: ") + SNESConvergedReasons[result.inner];
    if (result.inner == SNES_DIVERGED_LOCAL_MIN) failure_ += " (Newton's method does not come to rest)";
    if (const std::string adrift = loose_.adrift(); !adrift.empty()) failure_ += " (" + adrift + ")";
    if (result.inner == SNES_DIVERGED_LINEAR_SOLVE) {
      // Factors of a singular matrix must not serve the next try.
      forget_factors();
      if (!inertia_ && !motion_.rigid().empty())
        failure_ += " (a rigid body that contact alone holds must be pressed from the first iteration: "
                    "-contact_<id>_enforce semismooth, or prescribe its motion)";
    }
    return result;
  }
  Vec left = nullptr;
  check(SNESGetFunction(motion_snes_, &left, nullptr, nullptr));
  check(VecCopy(left, left_));
  // Of the present multipliers and of the places that the solve knew: both may change below.
  check(VecSet(contact_force_, 0));
  motion_.contacts().add_forces(u, -1, contact_force_);
  // A body that moved beyond the skin may touch facets that the list did not hold.
  const bool kept = !refresh_contact(u);
  if (pass == 1) motion_.contacts().start_augmentation();
  const bool converged = settled() && kept && !rough_;
  result.change = converged ? 0 : 1;
  if (converged) return result;
  // Multipliers change only where another solve follows, and not by penalties of places that it did not know.
  if (first_touch_) {
    first_touch_ = !kept || !motion_.contacts().review(u).settled;
    if (first_touch_) return result;
  }
  motion_.contacts().augment(u);
  motion_.contacts().meet(!loose_.empty(), false);
  rough_ = !inertia_ && augments();
  return result;
}

PassResult Coupling::coupling_pass(PetscInt pass, Vec u) {
  const InStage stage(Stage::motion);
  PassResult result;
  counts_.passes = pass;
  if (pass > 1 && damage_) phi_passes_.relax(pass, state_.row("phi"), phi_frozen_);
  if (pass > 1 && heat_) theta_frozen_ = state_.row("theta").trial;
  if (settings_.moves) {
    if (pass == 1) begin_newton(u, result);
    if (result.inner < 0) return result;
    // As long as the next pass moves the crack on, a residual that falls by ten is exact enough.
    const bool rough = phi_passes_.far_from_rest() && motion_.contacts().empty();
    check(SNESSetTolerances(motion_snes_, PETSC_DEFAULT,
                            rough ? std::max(0.1, residual_rtol_) : residual_rtol_, PETSC_DEFAULT,
                            PETSC_DEFAULT, PETSC_DEFAULT));
    check(SNESSolve(uzawa_snes_, nullptr, u));
    check(SNESGetConvergedReason(uzawa_snes_, &result.inner));
    if (result.inner < 0) {
      if (failure_.empty()) failure_ = std::string("uzawa: ") + SNESConvergedReasons[result.inner];
      return result;
    }
  }
  HeatRows rows = heat_ ? heat_->rows() : HeatRows{};
  if (!dissipation_.empty()) rows.dissipation = &dissipation_;
  std::fill(dissipation_.begin(), dissipation_.end(), 0.0);
  if ((settings_.moves || damage_) && !motion_.advance(u, increments_, rows)) {
    cell_broke_ = true;
    failure_ = "the law failed at the solution";
    result.inner = SNES_DIVERGED_FUNCTION_DOMAIN;
    return result;
  }
  limit_plastic_strain(result);
  if (result.inner < 0) return result;
  if (damage_ || heat_) motion_.discretisation().displacement.to_local(u, u_local_);
  if (damage_) damage_pass(result);
  if (fatigue_ && result.inner >= 0) fatigue_pass(result);
  if (heat_ && result.inner >= 0) heat_pass(u, result);
  return result;
}

void Coupling::heat_pass(Vec u, PassResult& result) {
  const InStage stage(Stage::heat);
  StateRow& theta = state_.row("theta");
  HeatStep step;
  if (settings_.moves) {
    step.u = &u_local_;
    step.u_n = step_.u_n;
    step.displacement = u;
  }
  if (damage_) {
    step.phi = &state_.row("phi").trial;
    step.phi_n = &state_.row("phi").committed;
  }
  if (!dissipation_.empty()) step.dissipation = &dissipation_;
  const HeatOutcome outcome = heat_->solve(step, theta.trial);
  counts_.heat += outcome.newton;
  counts_.heat_linear += outcome.linear;
  result.inner = outcome.reason;
  if (outcome.reason < 0) {
    failure_ = "heat: " + (outcome.cause.empty() ? SNESConvergedReasons[outcome.reason] : outcome.cause);
    if (outcome.cause.empty() && outcome.reason == SNES_DIVERGED_FUNCTION_DOMAIN)
      failure_ += " (0 K or less at a point of a cell, or values that are no numbers)";
    return;
  }
  const Discretisation& d = motion_.discretisation();
  if (settings_.max_dtheta > 0) {
    PetscReal step_change = 0;
    for (std::size_t i = 0; i < theta.trial.size(); ++i)
      step_change = std::max(step_change, std::abs(theta.trial[i] - theta.committed[i]));
    MPI_Allreduce(MPI_IN_PLACE, &step_change, 1, MPIU_REAL, MPIU_MAX, d.mesh.comm());
    limit(result, "the temperature changes", step_change, "dtheta", settings_.max_dtheta);
  }
  // Relative to the temperature: a ten-thousandth of it strains a metal by less than 1e-6. What no equation
  // reads needs no second pass.
  if (!d.temperature_moves()) return;
  PetscReal change_and_size[2] = {0, 0};
  for (std::size_t i = 0; i < theta.trial.size(); ++i) {
    change_and_size[0] = std::max(change_and_size[0], std::abs(theta.trial[i] - theta_frozen_[i]));
    change_and_size[1] = std::max(change_and_size[1], theta.trial[i]);
  }
  MPI_Allreduce(MPI_IN_PLACE, change_and_size, 2, MPIU_REAL, MPIU_MAX, d.mesh.comm());
  // The shell compares with the tolerance of phi.
  const PetscReal change = change_and_size[0] / change_and_size[1],
                  scale = settings_.theta_tol > 0 ? settings_.atol / settings_.theta_tol : 1;
  if (scale * change <= result.change) return;
  result.change = scale * change;
  changing_ = "the temperature";
}

void Coupling::fatigue_pass(PassResult& result) {
  FatigueStep step;
  step.dt = step_.dt;
  step.u = &u_local_;
  step.u_n = step_.u_n;
  step.phi = &state_.row("phi").trial;
  if (heat_) {
    step.theta = &theta_frozen_;
    step.theta_n = &state_.row("theta").committed;
  }
  if (fatigue_->advance(step)) return;
  failure_ = "fatigue: its growth is not finite";
  result.inner = SNES_DIVERGED_FUNCTION_DOMAIN;
}

// What flies deep into another body within a step leaves Newton's method a start with cells turned inside
// out, whose balance need not be that of the bodies.
void Coupling::limit_closing(PassResult& result, Vec u) {
  if (!inertia_ || settings_.max_closing <= 0 || at_least_step()) return;
  for (const ContactInterface& contact : motion_.contacts()) {
    const double depth = contact.closed_within_step(u, settings_.max_closing);
    if (depth == 0) continue;
    char text[200];
    std::snprintf(text, sizeof(text), "contact %.80s would close %.3g facets deep, -ts_adapt_closing is %.3g",
                  contact.id().c_str(), depth, settings_.max_closing);
    failure_ = text;
    result.inner = SNES_DIVERGED_INNER;
    return;
  }
}

void Coupling::limit(PassResult& result, const char* what, double increment, const char* option,
                     double most) {
  utilisation_ = std::max<PetscReal>(utilisation_, increment / most);
  // What jumps in any step, such as a rate-independent crack, may do so in one below a thousandth of -ts_dt.
  if (increment <= most || at_least_step()) return;
  char text[120];
  std::snprintf(text, sizeof(text), "%s by %.3g, -ts_adapt_%s is %.3g", what, increment, option, most);
  failure_ = text;
  result.inner = SNES_DIVERGED_INNER;
}

void Coupling::limit_plastic_strain(PassResult& result) {
  if (settings_.max_dalpha <= 0) return;
  const StateRow& history = state_.row("history");
  const auto components = static_cast<std::size_t>(history.components);
  const auto alpha = static_cast<std::size_t>(history_alpha(motion_.discretisation().frame));
  PetscReal growth = 0;
  for (std::size_t i = alpha * lanes; i < history.trial.size(); i += components * lanes)
    for (std::size_t l = 0; l < lanes; ++l)
      growth = std::max(growth, history.trial[i + l] - history.committed[i + l]);
  MPI_Allreduce(MPI_IN_PLACE, &growth, 1, MPIU_REAL, MPIU_MAX, motion_.discretisation().mesh.comm());
  limit(result, "the plastic strain grows", growth, "dalpha", settings_.max_dalpha);
}

void Coupling::parts_of_next_pass(Vec u, ForceParts& parts) {
  const std::vector<double> phi = phi_frozen_, theta = theta_frozen_;
  if (damage_) phi_frozen_ = state_.row("phi").trial;
  if (heat_) theta_frozen_ = state_.row("theta").trial;
  motion_.parts(u, parts);
  phi_frozen_ = phi;
  theta_frozen_ = theta;
}

void Coupling::damage_pass(PassResult& result) {
  const InStage stage(Stage::damage);
  StateRow& phi = state_.row("phi");
  DamageStep step;
  step.t = step_.t;
  step.dt = step_.dt;
  step.u = &u_local_;
  step.u_n = step_.u_n;
  step.phi_n = &phi.committed;
  phi.trial = phi_frozen_;
  const DamageOutcome outcome = damage_->solve(step, phi.trial);
  counts_.damage += outcome.newton;
  counts_.damage_linear += outcome.linear;
  result.inner = outcome.reason;
  if (outcome.reason < 0) {
    failure_ = std::string("damage: ") + SNESConvergedReasons[outcome.reason];
    return;
  }
  for (std::size_t i = 0; i < dissipation_.size(); ++i) dissipation_[i] += damage_->dissipated()[i];
  const PhiPasses::Change change = phi_passes_.note(phi_frozen_, phi);
  result.change = change.of_pass;
  result.counts = !(settings_.follow_cracks && change.gained);
  changing_ = "phi";
  if (phi_passes_.crack_runs()) report_crack();
  if (settings_.max_dphi > 0) limit(result, "phi grows", change.growth, "dphi", settings_.max_dphi);
}

// A run of many passes must not look like one that hangs.
void Coupling::report_crack() {
  constexpr double pause = 10; // seconds
  const MPI_Comm comm = motion_.discretisation().mesh.comm();
  int due = MPI_Wtime() - said_ > pause;
  MPI_Bcast(&due, 1, MPI_INT, 0, comm);
  if (!due) return;
  said_ = MPI_Wtime();
  check(PetscPrintf(comm, "impact: crack runs, pass %d, %s\n", static_cast<int>(counts_.passes),
                    crack_length(state_.row("phi").trial).c_str()));
}

std::string Coupling::crack_length(const std::vector<double>& phi) const {
  char text[80];
  std::snprintf(text, sizeof(text), "phi > %.3g on %.4g %s", settings_.crack_level,
                phi_passes_.extent(phi, settings_.crack_level), settings_.length_unit.c_str());
  return text;
}

std::string Coupling::crack_text() const {
  if (!phi_passes_.crack_runs()) return "";
  const StateRow& phi = state_.row("phi");
  char text[120];
  std::snprintf(text, sizeof(text), ", %.4g before; %d passes",
                phi_passes_.extent(phi.committed, settings_.crack_level), static_cast<int>(counts_.passes));
  return "crack ran: " + crack_length(phi.trial) + text;
}

std::string Coupling::failure_text() const {
  const std::string cell = cell_broke_ ? motion_.broken_text() : "";
  return cell.empty() ? failure_ : cell;
}

} // namespace impact
