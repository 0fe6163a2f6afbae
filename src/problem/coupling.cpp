#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <impact/petsc/error.hpp>
#include <impact/petsc/field_solver.hpp>
#include <impact/petsc/forget.hpp>
#include <impact/petsc/log.hpp>
#include <impact/problem/cell_loop.hpp>
#include <impact/problem/coupling.hpp>
#include <impact/time/types.hpp>

namespace impact {

namespace {

// A residual within this multiple of its tolerance is near the solution.
constexpr double near_balance = 10;

double longitudinal_speed(const MaterialParameters& p) { return std::sqrt((p.K + 4 * p.G / 3) / p.rho); }

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

// Whether m tau- of broken points acts like a contact. Not in sheets, whose thickness gives way: compression
// is never more than 1 + 4G/3K times as stiff as tension there.
bool has_unilateral_stress(const Discretisation& d) {
  return d.frame != Frame::plane_stress &&
         std::any_of(d.materials.begin(), d.materials.end(), [](const MaterialAssignment& m) {
           return m.law.parameters.damage != Damage::none && m.law.parameters.split != Split::none;
         });
}

std::string option_text(const char* name) {
  char text[128] = "";
  PetscBool set = PETSC_FALSE;
  check(PetscOptionsGetString(nullptr, nullptr, name, text, sizeof(text), &set));
  return set ? text : "";
}

// Its own options are read later.
void set_solver_defaults(KSP ksp, const SolverDefaults& defaults) {
  const bool half = defaults.matrix == MatrixFormat::sbaij;
  int ranks = 1;
  PC pc = nullptr;
  check(KSPGetPC(ksp, &pc));
  MPI_Comm_size(PetscObjectComm(reinterpret_cast<PetscObject>(ksp)), &ranks);
  if (defaults.direct) {
    check(KSPSetType(ksp, KSPPREONLY));
    check(PCSetType(pc, half ? PCCHOLESKY : PCLU));
    check(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
  } else if (defaults.multigrid) {
    check(KSPSetType(ksp, KSPGMRES));
    // The blocks of bjacobi are factorised like the matrix of one rank: a symmetric format by ICC.
    check(PCSetType(pc, !half ? PCGAMG : ranks == 1 ? PCICC : PCBJACOBI));
    check(KSPSetTolerances(ksp, 1e-8, PETSC_DEFAULT, PETSC_DEFAULT, half ? 10000 : 1000));
  } else {
    check(KSPSetType(ksp, KSPCG));
    check(PCSetType(pc, PCJACOBI));
    check(KSPSetTolerances(ksp, 1e-8, PETSC_DEFAULT, PETSC_DEFAULT, 10000));
  }
}

} // namespace

SolverDefaults choose_solver(const Discretisation& d, TangentChoice tangent, bool inertia, double dt,
                             SolverDemands demands, std::optional<MatrixFormat> matrix) {
  SolverDefaults choice;
  const auto dofs = d.mesh.global_node_count() * d.dim();
  double speed = 0;
  for (const MaterialAssignment& m : d.materials)
    if (m.law.parameters.rho > 0 && !m.law.rigid())
      speed = std::max(speed, longitudinal_speed(m.law.parameters));
  choice.cfl = inertia ? dt * speed / d.mesh.smallest_edge() : 0;
  char text[160];
  const bool small = dofs <= (d.dim() == 2 ? 100000 : 20000);
  if (choice.resolves_waves() && !d.has_viscosity() && !demands.frictional && !demands.rigid &&
      !(demands.closes_gaps && small)) {
    choice.direct = false;
    choice.symmetric = true;
    std::snprintf(text, sizeof(text), "dt is %.3g times h/c_p", choice.cfl);
  } else if (small) {
    std::snprintf(text, sizeof(text), "%lld dofs", static_cast<long long>(dofs));
  } else {
    choice.direct = false;
    choice.multigrid = true;
    std::snprintf(text, sizeof(text), "%lld dofs", static_cast<long long>(dofs));
  }
  choice.reason = text;
  const std::string ksp = option_text("-motion_ksp_type"), pc = option_text("-motion_pc_type");
  // A preconditioner that only improves a guess wants a Krylov method around it.
  const bool exact = pc.empty() || pc == "lu" || pc == "cholesky";
  if (ksp.empty() && !exact && choice.direct) choice.direct = false, choice.multigrid = true;
  if (!ksp.empty()) choice.symmetric = ksp == "cg" || ksp == "minres";
  if (!ksp.empty() || !pc.empty()) choice.reason = "chosen by options";
  if (tangent != TangentChoice::automatic) choice.symmetric = tangent == TangentChoice::symmetric;
  // Products and assembly of the half take less than half the time of a run with conjugate gradients.
  const bool own = ksp.empty() && pc.empty() && !choice.direct && !choice.multigrid;
  choice.matrix = matrix.value_or(own && choice.symmetric && !demands.unsymmetric ? MatrixFormat::sbaij
                                                                                  : MatrixFormat::aij);
  return choice;
}

void check_preconditioner(KSP ksp, MatrixFormat matrix) {
  if (matrix != MatrixFormat::sbaij) return;
  int ranks = 1;
  PC pc = nullptr;
  PCType type = nullptr;
  check(KSPGetPC(ksp, &pc));
  check(PCGetType(pc, &type));
  MPI_Comm_size(PetscObjectComm(reinterpret_cast<PetscObject>(ksp)), &ranks);
  const std::string name = type ? type : PCNONE;
  if (name == PCCHOLESKY || name == PCBJACOBI || name == PCJACOBI || name == PCNONE) return;
  if (name == PCICC && ranks == 1) return;
  throw UserError(ExitCode::usage, "-motion_pc_type \"" + name +
                                       "\": cannot work with -motion_mat_type sbaij; allowed: cholesky, " +
                                       (ranks == 1 ? "icc, " : "") +
                                       "bjacobi, jacobi, none; choose one of them, or -motion_mat_type aij");
}

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

bool Coupling::frictional() const {
  const auto& contacts = motion_.contacts();
  return std::any_of(contacts.begin(), contacts.end(), [](const auto& c) { return c.frictional(); });
}

bool Coupling::reverses() const {
  const auto& contacts = motion_.contacts();
  return std::any_of(contacts.begin(), contacts.end(), [](const auto& c) { return c.reverses(); });
}

bool Coupling::semismooth() const {
  const auto& contacts = motion_.contacts();
  return std::any_of(contacts.begin(), contacts.end(), [](const auto& c) { return c.semismooth(); });
}

bool Coupling::augments() const {
  const auto& contacts = motion_.contacts();
  return std::any_of(contacts.begin(), contacts.end(), [](const auto& c) { return c.augments(); });
}

// Multipliers of the semismooth method follow every iterate, before the residual is evaluated there; the
// solve ends when they have come to rest too.
void Coupling::update_multipliers_in(SNES snes) {
  // The first multipliers, or the first touch of a body that lay free, may raise the norm of a residual that
  // was nearly zero by any factor.
  if (semismooth() || !loose_.empty()) check(SNESSetDivergenceTolerance(snes, -1));
  SNESLineSearch search = nullptr;
  check(SNESGetLineSearch(snes, &search));
  check(SNESLineSearchSetPostCheck(
      search,
      [](SNESLineSearch, Vec x, Vec y, Vec w, PetscBool*, PetscBool* changed, void* context) {
        auto& self = *static_cast<Coupling*>(context);
        if (!self.semismooth() && self.motion_.rigid().empty() && !self.frictional() && self.loose_.empty())
          return PetscErrorCode(0);
        return time_mailbox(self.ts_).guarded([&] {
          if (const double part = self.loose_.empty() ? 1 : self.loose_.part_of(y); part < 1) {
            check(VecWAXPY(w, -part, y, x));
            *changed = PETSC_TRUE;
          }
          if (self.reverses()) {
            check(VecWAXPY(w, -1, y, x));
            *changed = PETSC_TRUE;
          }
          // Not w, unless a body turned, but the residual there.
          if (self.semismooth() || !self.motion_.rigid().empty()) *changed = PETSC_TRUE;
          const Handle<Vec> step = self.motion_.discretisation().displacement.make_global();
          check(VecWAXPY(step, -1, x, w));
          self.motion_.rigid().retract(w);
          if (self.first_way_)
            for (ContactInterface& contact : self.motion_.contacts())
              if (contact.follow_sliding(w)) self.reuse_.forget();
          if (!self.semismooth()) return;
          bool other_set = false;
          for (ContactInterface& contact : self.motion_.contacts())
            if (contact.semismooth()) other_set = contact.take_newton_step(x, step, w) || other_set;
          if (other_set) self.reuse_.forget();
        });
      },
      this));
  KSP ksp = nullptr;
  check(SNESGetKSP(snes, &ksp));
  check(KSPSetPreSolve(
      ksp,
      [](KSP, Vec rhs, Vec, void* context) {
        auto& self = *static_cast<Coupling*>(context);
        if (!self.closes_gaps()) return PetscErrorCode(0);
        return time_mailbox(self.ts_).guarded([&] {
          check(VecCopy(rhs, self.bare_residual_));
          self.add_gaps(self.iterate_, rhs);
        });
      },
      this));
  check(KSPSetPostSolve(
      ksp,
      [](KSP, Vec rhs, Vec du, void* context) {
        auto& self = *static_cast<Coupling*>(context);
        return time_mailbox(self.ts_).guarded([&] {
          if (self.closes_gaps()) check(VecCopy(self.bare_residual_, rhs));
          if (self.motion_.rigid().empty()) return;
          self.motion_.rigid().place(self.iterate_);
          self.motion_.rigid().expand(du);
        });
      },
      this));
  check(SNESSetConvergenceTest(
      snes,
      [](SNES solver, PetscInt it, PetscReal, PetscReal, PetscReal f, SNESConvergedReason* reason,
         void* context) {
        auto& self = *static_cast<Coupling*>(context);
        return time_mailbox(self.ts_).guarded([&] {
          ForceBalance& balance = self.motion_.balance();
          if (it == 0) {
            if (!self.first_done_) balance.start();
            self.watch_.start(self.line_search() == SNESLINESEARCHBASIC);
            self.near_ = 0;
            self.open_ = HUGE_VAL;
          }
          *reason = balance.test(solver, it, f);
          Vec u = nullptr;
          check(SNESGetSolution(solver, &u));
          if (self.semismooth() && balance.ratio() <= near_balance && !self.gaps_settle(u) && *reason > 0)
            *reason = SNES_CONVERGED_ITERATING;
          if (*reason == SNES_CONVERGED_ITERATING && self.watched_ && self.gives_up(f))
            *reason = SNES_DIVERGED_LOCAL_MIN;
        });
      },
      this, nullptr));
}

void Coupling::add_gaps(Vec u, Vec f) {
  Vec gaps = f;
  Handle<Vec> apart; // of what rigid bodies feel already
  if (!motion_.rigid().empty()) {
    apart = motion_.discretisation().displacement.make_global();
    gaps = apart;
  }
  for (const ContactInterface& contact : motion_.contacts()) contact.add_gaps(u, step_.contact_scale, gaps);
  if (!apart) return;
  motion_.rigid().place(u);
  motion_.rigid().reduce(apart);
  check(VecAXPY(f, 1, apart));
}

// Imposes the prescribed values and, where that is worth while, takes the first iteration of the step.
// Prescribed nodes that jump ahead of their neighbours leave the whole increment to one layer of cells, and a
// search for the smallest residual shortens the steps of slender bodies, whose linear answer stretches them
// before the next iteration turns it. So the first iteration stands at the guess, takes the prescribed nodes
// along and goes all the way.
void Coupling::begin_newton(Vec u, PassResult& result) {
  const Discretisation& d = motion_.discretisation();
  Handle<Vec> goal = d.displacement.make_global();
  const Handle<Vec> ahead = d.displacement.make_global();
  check(VecCopy(u, goal));
  motion_.impose(goal);
  refresh_contact(goal);
  limit_closing(result, goal);
  if (result.inner < 0) return;
  motion_.rigid().retract(u);
  check(VecWAXPY(ahead, -1, u, goal));
  PetscReal largest = 0;
  check(VecNorm(ahead, NORM_INFINITY, &largest));
  // A jump below that strains the layer by so little that its answer is linear too.
  const double small = 1e-7 * d.mesh.smallest_edge();
  if (largest <= small) check(VecCopy(goal, u));
  // What nothing holds yet has no such answer: its steps are limited ones (H3).
  first_done_ = loose_.empty() && (largest > small || line_search() == SNESLINESEARCHL2) &&
                take_first_step(u, largest > small ? ahead.get() : nullptr, small / largest);
  if (!first_done_) check(VecCopy(goal, u));
}

// K_ff du_f = -r - K_fc du_c at u, where `ahead` is du_c, or null. K_fc du_c is a difference of the residual
// over a small `part` of it, whatever makes it up. False where there is nothing to do, or the answer is no
// better than the guess: the energy's slope along the step, zero at the end if all was linear, is still as
// large as at its start.
bool Coupling::take_first_step(Vec u, Vec ahead, double part) {
  const Discretisation& d = motion_.discretisation();
  refresh_contact(u);
  for (ContactInterface& contact : motion_.contacts()) contact.start_newton(u);
  const Handle<Vec> r = d.displacement.make_global(), other = d.displacement.make_global(),
                    step = d.displacement.make_global(), start = d.displacement.make_global();
  PetscReal atol = 0, rtol = 0, slope[2] = {0, 0}, norm[2] = {0, 0};
  check(SNESGetTolerances(motion_snes_, &atol, &rtol, nullptr, nullptr, nullptr));
  iterate_ = u;
  tangents_ = 0;
  check(VecCopy(u, start));
  check(SNESComputeFunction(motion_snes_, u, r));
  if (ahead != nullptr) {
    check(VecAXPY(u, part, ahead));
    check(SNESComputeFunction(motion_snes_, u, other));
    check(VecCopy(r, step));
    if (closes_gaps()) {
      add_gaps(u, other);
      add_gaps(start, step);
    }
    check(VecCopy(start, u));
    check(VecAXPY(other, -1, step));
    check(VecAXPY(r, 1 / part, other));
  }
  motion_.balance().start();
  motion_.balance().judge(r, atol, rtol);
  if (cell_broke_ || motion_.balance().holds()) return cell_broke_ = false;
  check(VecNorm(r, NORM_2, &norm[0]));
  check(SNESMonitor(motion_snes_, 0, norm[0])); // that of the next iteration follows, under the number 0 too
  KSP ksp = nullptr;
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  PetscInt linear = 0;
  check(SNESComputeJacobian(motion_snes_, u, motion_.jacobian(), motion_.matrix()));
  check(SNESGetKSP(motion_snes_, &ksp));
  check(KSPSetOperators(ksp, motion_.jacobian(), motion_.matrix()));
  check(KSPSolve(ksp, r, step));
  check(KSPGetConvergedReason(ksp, &reason));
  check(KSPGetIterationNumber(ksp, &linear));
  counts_.newton += 1;
  counts_.linear += linear;
  iterations_ = 1;
  if (reason < 0 || cell_broke_) return cell_broke_ = false;
  check(VecAXPY(u, -1, step));
  motion_.impose(u);
  if (semismooth()) {
    check(VecWAXPY(other, -1, start, u));
    for (ContactInterface& contact : motion_.contacts())
      if (contact.semismooth()) contact.take_newton_step(start, other, u);
  } else {
    check(SNESComputeFunction(motion_snes_, u, other));
    check(VecDot(r, step, &slope[0]));
    check(VecDot(other, step, &slope[1]));
    check(VecNorm(other, NORM_2, &norm[1]));
    if (cell_broke_ || !(std::abs(slope[1]) < std::abs(slope[0]))) return cell_broke_ = false;
    if (norm[1] > reuse_.reduction() * norm[0]) reuse_.forget();
  }
  return true;
}

// Whether nothing is left open that another iteration closes.
bool Coupling::gaps_settle(Vec u) {
  const double before = open_;
  bool closed = true;
  open_ = 0;
  for (const ContactInterface& contact : motion_.contacts()) {
    const ContactInterface::GapsLeft left = contact.gaps_left(u, motion_.balance().force());
    closed = closed && left.closed;
    open_ = std::max(open_, left.open);
  }
  return closed || (open_ > before / 2 && open_ <= ContactInterface::most_open);
}

bool Coupling::gives_up(PetscReal norm) {
  // Newton's method passes the last decade in an iteration or two, unless rounding is as large, or there are
  // more constraints than the surfaces can meet: no pressure closes the gaps that they leave.
  constexpr int most_near = 6;
  watch_.note(norm);
  if (motion_.balance().ratio() <= near_balance) ++near_;
  return watch_.cycle() > 0 || watch_.stalls() || near_ >= most_near;
}

SNESConvergedReason Coupling::solve_motion(Vec u) {
  check(VecCopy(u, newton_start_));
  iterations_ = first_done_ ? 1 : 0;
  const bool contact = !motion_.contacts().empty();
  SNESConvergedReason reason = SNES_DIVERGED_MAX_IT;
  if (!second_way_first_) {
    watched_ = contact && has_second_way();
    first_way_ = true;
    reason = run_motion(u);
    first_way_ = watched_ = false;
  }
  const bool lost =
      reason == SNES_DIVERGED_MAX_IT || reason == SNES_DIVERGED_DTOL || reason == SNES_DIVERGED_LOCAL_MIN;
  if (lost && has_second_way() && !first_touch_) {
    // With contact both ways together take no more than one may; what has nothing left for the second one
    // begins the next try of the step with it.
    PetscInt most = 0;
    check(SNESGetTolerances(motion_snes_, nullptr, nullptr, nullptr, &most, nullptr));
    if (const PetscInt left = contact ? most - iterations_ : most; left > 0) reason = go_second_way(u, left);
    if (contact && iterations_ >= most && reason < 0) second_way_first_ = !second_way_first_;
  }
  counts_.longest = std::max(counts_.longest, iterations_);
  return reason;
}

std::string Coupling::line_search() const {
  SNESLineSearch search = nullptr;
  SNESLineSearchType type = nullptr;
  check(SNESGetLineSearch(motion_snes_, &search));
  check(SNESLineSearchGetType(search, &type));
  return type ? type : "";
}

bool Coupling::has_second_way() const { return !line_search().empty() && line_search() != SNESLINESEARCHBT; }

// Where points close or open, or volume changes its sign in a crack, Newton may jump to and fro between two
// states however small the step. Backtracking does not let the residual rise, so it leaves such a cycle. An
// active set that does not come to rest: multipliers outside Newton's method do not change it.
SNESConvergedReason Coupling::go_second_way(Vec u, PetscInt most_iterations) {
  const std::string first = line_search();
  SNESLineSearch search = nullptr;
  PetscInt most = 0;
  ++second_ways_;
  check(SNESGetLineSearch(motion_snes_, &search));
  check(SNESGetTolerances(motion_snes_, nullptr, nullptr, nullptr, &most, nullptr));
  for (ContactInterface& contact : motion_.contacts())
    if (contact.semismooth()) contact.fall_back();
  check(VecCopy(newton_start_, u));
  for (ContactInterface& contact : motion_.contacts()) contact.start_newton(u);
  reuse_.forget();
  check(SNESLineSearchSetType(search, SNESLINESEARCHBT));
  check(SNESSetTolerances(motion_snes_, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT, most_iterations,
                          PETSC_DEFAULT));
  const SNESConvergedReason reason = run_motion(u);
  check(SNESSetTolerances(motion_snes_, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT, most, PETSC_DEFAULT));
  check(SNESLineSearchSetType(search, first.c_str()));
  return reason;
}

SNESConvergedReason Coupling::run_motion(Vec u) {
  tangents_ = first_done_ ? 1 : 0;
  iterate_ = u;
  PetscInt most = 0;
  check(SNESGetTolerances(motion_snes_, nullptr, nullptr, nullptr, &most, nullptr));
  const auto allow = [&](PetscInt iterations) {
    check(SNESSetTolerances(motion_snes_, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT, iterations,
                            PETSC_DEFAULT));
  };
  allow(std::max<PetscInt>(most - tangents_, 0));
  loose_.start_solve();
  check(SNESSolve(motion_snes_, nullptr, u));
  allow(most);
  first_done_ = false;
  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  PetscInt newton = 0, linear = 0;
  check(SNESGetConvergedReason(motion_snes_, &reason));
  check(SNESGetIterationNumber(motion_snes_, &newton));
  check(SNESGetLinearSolveIterations(motion_snes_, &linear));
  // No reason but a residual within its tolerance counts. A line search that found none smaller may have met
  // its rounding, which the last tangent told.
  if (reason > 0 && !motion_.balance().holds()) reason = SNES_DIVERGED_LINE_SEARCH;
  if (reason == SNES_DIVERGED_LINE_SEARCH && !cell_broke_ && balanced(u))
    reason = SNES_CONVERGED_FNORM_RELATIVE;
  counts_.newton += newton;
  iterations_ += newton;
  hardest_solve_ = std::max(hardest_solve_, tangents_);
  counts_.linear += linear;
  return reason;
}

bool Coupling::balanced(Vec u) {
  PetscReal atol = 0, rtol = 0;
  check(SNESGetTolerances(motion_snes_, &atol, &rtol, nullptr, nullptr, nullptr));
  check(SNESComputeFunction(motion_snes_, u, residual_));
  motion_.balance().judge(residual_, atol, rtol);
  const auto& contacts = motion_.contacts();
  return motion_.balance().holds() && std::all_of(contacts.begin(), contacts.end(), [&](const auto& c) {
           return c.gaps_left(u, motion_.balance().force()).closed;
         });
}

// What faces what is found between the Newton solves: a loose body that faces nothing yet strides towards
// what the search sees, one iteration at a time.
void Coupling::approach(Vec u) {
  PetscInt most = 0;
  check(SNESGetTolerances(motion_snes_, nullptr, nullptr, nullptr, &most, nullptr));
  for (PetscInt stride = 0; stride < most && loose_.sees_only(u); ++stride) {
    check(SNESSetTolerances(motion_snes_, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT, 1, PETSC_DEFAULT));
    const SNESConvergedReason reason = run_motion(u);
    check(SNESSetTolerances(motion_snes_, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT, most, PETSC_DEFAULT));
    if (reason != SNES_DIVERGED_MAX_IT) return;
    refresh_contact(u);
  }
}

PassResult Coupling::uzawa_pass(PetscInt pass, Vec u) {
  PassResult result;
  refresh_contact(u);
  if (!loose_.empty()) approach(u);
  // What presses nothing yet is brought to rest on penalties, roughly: their forces grow with the way, and
  // the semismooth method, whose gaps close at once, begins from the pressures that they find.
  if (pass == 1) first_touch_ = (semismooth() || augments()) && !loose_.empty() && !loose_.rest(u);
  for (ContactInterface& contact : motion_.contacts()) {
    contact.meet(!loose_.empty(), first_touch_);
    contact.start_newton(u);
  }
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
  const auto settled = [&] {
    const auto& contacts = motion_.contacts();
    return std::all_of(contacts.begin(), contacts.end(),
                       [&](const auto& c) { return c.review(u).converged; });
  };
  result.inner = solve_to(rough_ ? std::max(rtol, 0.1) : rtol);
  if (first_touch_ && result.inner < 0) {
    first_touch_ = rough_ = cell_broke_ = false;
    loose_.start_attempt();
    check(VecCopy(newton_start_, u));
    for (ContactInterface& contact : motion_.contacts()) {
      contact.meet(!loose_.empty(), false);
      contact.start_newton(u);
    }
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
  for (ContactInterface& contact : motion_.contacts()) contact.add_residual(u, -1, contact_force_);
  // A body that moved beyond the skin may touch facets that the list did not hold.
  const bool kept = !refresh_contact(u);
  auto& contacts = motion_.contacts();
  if (pass == 1)
    for (ContactInterface& contact : contacts) contact.start_augmentation();
  const bool converged = settled() && kept && !rough_;
  result.change = converged ? 0 : 1;
  if (converged) return result;
  // Multipliers change only where another solve follows, and not by penalties of places that it did not know.
  if (first_touch_) {
    first_touch_ = !kept || std::any_of(contacts.begin(), contacts.end(),
                                        [&](const auto& c) { return !c.review(u).settled; });
    if (first_touch_) return result;
  }
  for (ContactInterface& contact : contacts) {
    contact.augment(u);
    contact.meet(!loose_.empty(), false);
  }
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
  const Discretisation& d = motion_.discretisation();
  if (!cell_broke_) return failure_;
  // The worst cell of all ranks speaks.
  struct {
    double J;
    int rank;
  } mine, worst;
  MPI_Comm_rank(d.mesh.comm(), &mine.rank);
  const BrokenCell& broken = motion_.broken();
  mine.J = broken.material < 0 ? HUGE_VAL : std::isfinite(broken.min_J) ? broken.min_J : -HUGE_VAL;
  MPI_Allreduce(&mine, &worst, 1, MPI_DOUBLE_INT, MPI_MINLOC, d.mesh.comm());
  if (worst.J == HUGE_VAL) return failure_;
  double data[5] = {broken.min_J, broken.x[0], broken.x[1], broken.x[2],
                    static_cast<double>(broken.material)};
  MPI_Bcast(data, 5, MPI_DOUBLE, worst.rank, d.mesh.comm());
  char text[240];
  const char* what = data[0] <= 0 ? "cell inverted" : "law failed in a cell";
  const auto& id = d.materials[static_cast<std::size_t>(data[4])].law.parameters.id;
  if (d.dim() == 2)
    std::snprintf(text, sizeof(text), "%s (J=%.3g) at x=(%.6g,%.6g) in material %s", what, data[0], data[1],
                  data[2], id.c_str());
  else
    std::snprintf(text, sizeof(text), "%s (J=%.3g) at x=(%.6g,%.6g,%.6g) in material %s", what, data[0],
                  data[1], data[2], data[3], id.c_str());
  return text;
}

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
  double penetration = 0;
  std::vector<std::pair<StateRow*, std::vector<double>>> kept;
  for (ContactInterface& contact : motion_.contacts())
    for (const char* name : {"_multiplier", "_penalty"}) {
      StateRow& row = state_.row("contact_" + contact.id() + name);
      kept.emplace_back(&row, row.trial);
      if (name[1] == 'm') std::fill(row.trial.begin(), row.trial.end(), 0.0);
    }
  for (ContactInterface& contact : motion_.contacts()) {
    contact.suspend_friction(true);
    contact.linearise_at_start(true);
  }
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
  for (ContactInterface& contact : motion_.contacts())
    penetration = std::max(penetration, contact.review(u_tilde).penetration);
  if (penetration > 0) {
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
    for (ContactInterface& contact : motion_.contacts()) contact.start_augmentation();
    for (int pass = 0; pass < 10; ++pass) {
      check(SNESSolve(snes, nullptr, u_tilde));
      SNESConvergedReason why = SNES_CONVERGED_ITERATING;
      check(SNESGetConvergedReason(snes, &why));
      bool converged = why > 0;
      if (!converged) break;
      for (ContactInterface& contact : motion_.contacts())
        converged = contact.review(u_tilde).converged && converged;
      if (converged) break;
      for (ContactInterface& contact : motion_.contacts()) contact.augment(u_tilde);
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
      for (ContactInterface& contact : motion_.contacts()) {
        contact.add_residual(u_tilde, -0.5, contact_shock_);
        contact.keep_shock(u_tilde);
      }
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
  for (auto& [row, values] : kept) row->trial = std::move(values);
  for (ContactInterface& contact : motion_.contacts()) {
    contact.suspend_friction(false);
    contact.linearise_at_start(false);
  }
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

void Coupling::begin_at_rest_of_step(double t, Vec u, Vec v) {
  // Between steps the viscous stress still wants C at an earlier time: a backward step short against
  // everything else.
  const Discretisation& d = motion_.discretisation();
  read_contact_scale();
  PetscReal dt = 0;
  check(TSGetTimeStep(ts_, &dt));
  const double h = 1e-6 * dt;
  u_before_ = d.displacement.make_local();
  std::vector<double> rate = d.displacement.make_local();
  d.displacement.to_local(u, u_before_);
  d.displacement.to_local(v, rate);
  for (std::size_t i = 0; i < u_before_.size(); ++i) u_before_[i] -= h * rate[i];
  MotionStep step;
  step.t_n = t - h;
  step.t = t;
  step.dt = h;
  step.u_n = &u_before_;
  if (damage_) step.phi = &state_.row("phi").committed;
  if (heat_) step.theta = &state_.row("theta").committed;
  step.contact_scale = contact_scale_;
  step.unilateral_scale = unilateral_scale_;
  motion_.begin(step);
}

void Coupling::start_heat(Vec u) {
  if (!heat_ || !settings_.moves) return;
  const HeatRows rows = heat_->rows();
  if (!rows.stress) return;
  MotionProblem::Increments unused;
  motion_.advance(u, unused, {nullptr, rows.stress});
  state_.row("stress").committed = *rows.stress;
  state_.rollback();
}

void Coupling::start_damage(Vec u) {
  if (!damage_) return;
  motion_.discretisation().displacement.to_local(u, u_local_);
  damage_->start(u_local_);
}

double Coupling::prescribed_damage_work() const {
  return damage_ && !(heat_ && heat_->takes_work_of_damage()) ? damage_->prescribed_work() : 0;
}

void Coupling::initial_acceleration(double t, Vec u, Vec v, Vec a) {
  // M a_0 = F_ext - F_int(u_0, v_0) without contact on the free dofs; prescribed dofs keep the rate of their
  // data.
  const Discretisation& d = motion_.discretisation();
  begin_at_rest_of_step(t, u, v);
  ForceParts forces;
  motion_.parts(u, forces);
  check(VecAXPY(forces.external, -1, forces.internal));
  d.displacement.to_global(state_.row("a").committed, a);
  motion_.mass_solve(forces.external, a);
  motion_.rigid().accelerate(forces.external, a);
}

} // namespace impact
