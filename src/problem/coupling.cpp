#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <impact/petsc/error.hpp>
#include <impact/petsc/forget.hpp>
#include <impact/problem/cell_loop.hpp>
#include <impact/problem/coupling.hpp>
#include <impact/time/types.hpp>

namespace impact {

namespace {

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
                             ContactDemands contact, MatrixFormat matrix) {
  SolverDefaults choice;
  choice.matrix = matrix;
  const bool half = matrix == MatrixFormat::sbaij;
  const auto dofs = d.mesh.global_node_count() * d.dim();
  double speed = 0;
  for (const MaterialAssignment& m : d.materials)
    if (m.law.parameters.rho > 0 && !m.law.rigid())
      speed = std::max(speed, longitudinal_speed(m.law.parameters));
  choice.cfl = inertia ? dt * speed / d.mesh.smallest_edge() : 0;
  char text[160];
  const bool small = dofs <= (d.dim() == 2 ? 100000 : 20000);
  if (choice.resolves_waves() && !d.has_viscosity() && !contact.frictional && !contact.rigid &&
      !(contact.closes_gaps && small)) {
    choice.direct = false;
    choice.symmetric = true;
    std::snprintf(text, sizeof(text), "cg + jacobi (dt is %.3g times h/c_p)", choice.cfl);
  } else if (small) {
    const std::string package = option_text("-motion_pc_factor_mat_solver_type");
    std::snprintf(text, sizeof(text), "preonly + %s by %.40s (%lld dofs)", half ? "cholesky" : "lu",
                  package.empty() ? "mumps" : package.c_str(), static_cast<long long>(dofs));
  } else {
    choice.direct = false;
    choice.multigrid = true;
    std::snprintf(text, sizeof(text), "%s (%lld dofs)",
                  half ? "gmres + incomplete cholesky" : "gmres + gamg with rigid body modes",
                  static_cast<long long>(dofs));
  }
  choice.reason = text;
  const std::string ksp = option_text("-motion_ksp_type"), pc = option_text("-motion_pc_type");
  // A preconditioner that only improves a guess wants a Krylov method around it.
  const bool exact = pc.empty() || pc == "lu" || pc == "cholesky";
  if (ksp.empty() && !exact && choice.direct) choice.direct = false, choice.multigrid = true;
  if (!ksp.empty()) choice.symmetric = ksp == "cg" || ksp == "minres";
  if (!ksp.empty() || !pc.empty()) choice.reason = "as the options say";
  if (tangent != TangentChoice::automatic) choice.symmetric = tangent == TangentChoice::symmetric;
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
      inertia_(inertia), stabilise_(stabilise_contact && inertia && !motion.contacts().empty()) {
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
          if (self.reuse_.serves(self.motion_snes_, self.step_.dt, shift_a)) return;
          self.tangents_ += 1;
          if (self.motion_.tangent(u, self.inertia_ ? shift_a : 0)) return;
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
  check(SNESSetTolerances(motion_snes_, motion_.reference_force(), 1e-10, 1e-12, 25, PETSC_DEFAULT));
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
  check(SNESLineSearchSetType(search, semismooth() || frictional() ? SNESLINESEARCHBASIC : SNESLINESEARCHL2));
  check(SNESSetFromOptions(motion_snes_));
  check_preconditioner(ksp, defaults.matrix);
  check(SNESGetTolerances(motion_snes_, &residual_tol_, nullptr, nullptr, nullptr, nullptr));
  update_multipliers_in(motion_snes_);
  PetscBool factorises = PETSC_FALSE;
  check(PetscObjectTypeCompareAny(reinterpret_cast<PetscObject>(pc), &factorises, PCLU, PCCHOLESKY, ""));
  // An iteration with MUMPS costs a third of one that factorises before (2D, 5e3 dofs). Gaps that the linear
  // solves close need directions of the iterate, though: 4 iterations with full Newton, 15 without (patch
  // test).
  if (settings_.reuse >= 0)
    reuse_ = TangentReuse(settings_.reuse);
  else if (factorises && !semismooth())
    reuse_ = TangentReuse(0.1);
  PetscBool preonly = PETSC_FALSE;
  check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(ksp), KSPPREONLY, &preonly));
  if (shell && preonly)
    throw UserError(ExitCode::usage,
                    "-motion_ksp_type preonly: not with -contact_operator shell, whose preconditioner "
                    "does not see the contact; use gmres, or -contact_operator assembled");

  uzawa_shell_ = {[this](PetscInt pass, Vec u) { return uzawa_pass(pass, u); }, &time_mailbox(ts_)};
  check(SNESCreate(comm, uzawa_snes_.out()));
  check(SNESSetOptionsPrefix(uzawa_snes_, "uzawa_"));
  make_pass_shell(uzawa_snes_, uzawa_shell_);
  // The tolerances of gap and pressure belong to each contact: a pass changes 1 until all of them are met.
  check(SNESSetTolerances(uzawa_snes_, 0.5, 0, 0, 30, PETSC_DEFAULT));
  check(SNESSetFromOptions(uzawa_snes_));

  SNES coupling = nullptr;
  coupling_shell_ = {[this](PetscInt pass, Vec u) { return coupling_pass(pass, u); }, &time_mailbox(ts_)};
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
  if (!stabilise_) return;
  const NewmarkParameters p = newmark_parameters(ts_);
  contact_scale_ = p.alpha_m / (2 * p.beta);
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
  step_.stabilised = stabilise_;
  if (inertia_) {
    const NewmarkParameters p = newmark_parameters(ts_);
    step_.mass_shift = p.alpha_m / (p.beta * attempt.dt * attempt.dt);
  }
  if (damage_) {
    phi_frozen_ = state_.row("phi").committed;
    step_.phi = &phi_frozen_;
  }
  if (heat_) {
    heat_->begin(attempt.t_n, attempt.t);
    theta_frozen_ = state_.row("theta").committed;
    step_.theta = &theta_frozen_;
  }
  motion_.begin(step_);
  if (motion_.rigid().empty()) return;
  // Below the rounding of heavy bodies' inertia no residual can fall.
  const double least = std::max(residual_tol_, motion_.rigid().rounding(step_.mass_shift));
  check(SNESSetTolerances(motion_snes_, least, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
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

// Multipliers of the semismooth method follow every iterate, before the residual is evaluated there; the
// solve ends when they have come to rest too.
void Coupling::update_multipliers_in(SNES snes) {
  // The first multipliers may raise the norm of a residual that was nearly zero by any factor.
  if (semismooth()) check(SNESSetDivergenceTolerance(snes, -1));
  SNESLineSearch search = nullptr;
  check(SNESGetLineSearch(snes, &search));
  check(SNESLineSearchSetPostCheck(
      search,
      [](SNESLineSearch, Vec x, Vec y, Vec w, PetscBool*, PetscBool* changed, void* context) {
        auto& self = *static_cast<Coupling*>(context);
        if (!self.semismooth() && self.motion_.rigid().empty() && !self.frictional())
          return PetscErrorCode(0);
        return time_mailbox(self.ts_).guarded([&] {
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
          Vec u = nullptr;
          check(SNESGetSolution(self.solving_, &u));
          check(VecCopy(rhs, self.bare_residual_));
          Vec gaps = rhs;
          Handle<Vec> apart; // of what rigid bodies feel already
          if (!self.motion_.rigid().empty()) {
            apart = self.motion_.discretisation().displacement.make_global();
            gaps = apart;
          }
          for (const ContactInterface& contact : self.motion_.contacts())
            contact.add_gaps(u, self.step_.contact_scale, gaps);
          if (!apart) return;
          self.motion_.rigid().place(u);
          self.motion_.rigid().reduce(apart);
          check(VecAXPY(rhs, 1, apart));
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
          Vec u = nullptr;
          check(SNESGetSolution(self.solving_, &u));
          self.motion_.rigid().place(u);
          self.motion_.rigid().expand(du);
        });
      },
      this));
  check(SNESSetConvergenceTest(
      snes,
      [](SNES solver, PetscInt it, PetscReal x, PetscReal step, PetscReal f, SNESConvergedReason* reason,
         void* context) {
        const PetscErrorCode code = SNESConvergedDefault(solver, it, x, step, f, reason, nullptr);
        auto& self = *static_cast<Coupling*>(context);
        if (it == 0) {
          self.first_residual_ = f;
          self.watch_.start(self.line_search() == SNESLINESEARCHBASIC);
          self.near_ = 0;
        }
        if (code != 0 || *reason < 0) return code;
        return time_mailbox(self.ts_).guarded([&] {
          Vec u = nullptr;
          PetscReal atol = 0, rtol = 0;
          check(SNESGetSolution(solver, &u));
          check(SNESGetTolerances(solver, &atol, &rtol, nullptr, nullptr, nullptr));
          const double force = std::max(atol, rtol * self.first_residual_);
          if (*reason > 0 && self.semismooth())
            for (const ContactInterface& contact : self.motion_.contacts())
              if (!contact.gaps_closed(u, force)) *reason = SNES_CONVERGED_ITERATING;
          if (*reason == SNES_CONVERGED_ITERATING && self.watched_ && self.gives_up(f, force))
            *reason = SNES_DIVERGED_LOCAL_MIN;
        });
      },
      this, nullptr));
}

bool Coupling::gives_up(PetscReal norm, double tolerance) {
  // Newton's method passes the last decade in an iteration or two, unless rounding is as large, or there are
  // more constraints than the surfaces can meet: no pressure closes the gaps that they leave.
  constexpr int most_near = 6;
  watch_.note(norm);
  if (norm <= 10 * tolerance) ++near_;
  return watch_.cycle() > 0 || watch_.stalls() || near_ >= most_near;
}

SNESConvergedReason Coupling::solve_motion(Vec u) {
  check(VecCopy(u, newton_start_));
  iterations_ = 0;
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
  if (lost && has_second_way()) {
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
  tangents_ = 0;
  solving_ = motion_snes_;
  check(SNESSolve(motion_snes_, nullptr, u));
  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  PetscInt newton = 0, linear = 0;
  check(SNESGetConvergedReason(motion_snes_, &reason));
  check(SNESGetIterationNumber(motion_snes_, &newton));
  check(SNESGetLinearSolveIterations(motion_snes_, &linear));
  counts_.newton += newton;
  iterations_ += newton;
  hardest_solve_ = std::max(hardest_solve_, tangents_);
  counts_.linear += linear;
  return reason;
}

PassResult Coupling::uzawa_pass(PetscInt pass, Vec u) {
  PassResult result;
  refresh_contact(u);
  if (pass == 1 && counts_.passes == 1) limit_closing(result, u);
  if (result.inner < 0) return result;
  for (ContactInterface& contact : motion_.contacts()) contact.start_newton(u);
  result.inner = solve_motion(u);
  counts_.uzawa += 1;
  if (result.inner < 0) {
    failure_ = std::string("motion: ") + SNESConvergedReasons[result.inner];
    if (result.inner == SNES_DIVERGED_LOCAL_MIN) failure_ += " (Newton's method does not come to rest)";
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
  bool converged = !refresh_contact(u);
  for (ContactInterface& contact : motion_.contacts()) {
    if (pass == 1) contact.start_augmentation();
    converged = contact.review(u).converged && converged;
  }
  result.change = converged ? 0 : 1;
  // Multipliers change only where another solve follows.
  if (!converged)
    for (ContactInterface& contact : motion_.contacts()) contact.augment(u);
  return result;
}

PassResult Coupling::coupling_pass(PetscInt pass, Vec u) {
  PassResult result;
  counts_.passes = pass;
  if (pass > 1 && damage_) relax_phi(pass);
  if (pass > 1 && heat_) theta_frozen_ = state_.row("theta").trial;
  if (settings_.moves) {
    if (pass == 1) motion_.impose(u);
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
    failure_ = std::string("heat: ") + SNESConvergedReasons[outcome.reason];
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
  result.change = std::max(result.change, scale * change);
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
  PetscReal growth = 0;
  for (std::size_t i = (components - 1) * lanes; i < history.trial.size(); i += components * lanes)
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
  PetscReal change_and_growth[2] = {0, 0};
  std::swap(phi_change_before_, phi_change_);
  phi_change_.resize(phi.trial.size());
  for (std::size_t i = 0; i < phi.trial.size(); ++i) {
    phi_change_[i] = phi.trial[i] - phi_frozen_[i];
    change_and_growth[0] = std::max(change_and_growth[0], std::abs(phi_change_[i]));
    change_and_growth[1] = std::max(change_and_growth[1], phi.trial[i] - phi.committed[i]);
  }
  MPI_Allreduce(MPI_IN_PLACE, change_and_growth, 2, MPIU_REAL, MPIU_MAX,
                motion_.discretisation().mesh.comm());
  result.change = change_and_growth[0];
  if (settings_.max_dphi > 0) limit(result, "phi grows", change_and_growth[1], "dphi", settings_.max_dphi);
}

double Coupling::owned_dot(const std::vector<double>& a, const std::vector<double>& b) const {
  const Mesh& mesh = motion_.discretisation().mesh;
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (mesh.owned(static_cast<int>(i))) sum += a[i] * b[i];
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPIU_REAL, MPIU_SUM, mesh.comm());
  return sum;
}

void Coupling::relax_phi(PetscInt pass) {
  // The error of the passes falls by a nearly constant factor, 0.8 and more beside an open crack. Aitken's
  // extrapolation takes that factor from two changes; while the changes grow the crack runs, and is not
  // hurried.
  const StateRow& phi = state_.row("phi");
  if (settings_.relaxation == PassRelaxation::none || pass < 3) {
    phi_frozen_ = phi.trial;
    relaxation_ = 1;
    return;
  }
  const double before = owned_dot(phi_change_before_, phi_change_before_);
  const double mixed = owned_dot(phi_change_before_, phi_change_);
  const double now = owned_dot(phi_change_, phi_change_);
  const double curvature = before - 2 * mixed + now;
  constexpr double longest = 10;
  const double factor = curvature > 0 ? relaxation_ * (before - mixed) / curvature : 0;
  relaxation_ = now < before && factor > 1 ? std::min(factor, longest) : 1;
  for (std::size_t i = 0; i < phi_frozen_.size(); ++i)
    phi_frozen_[i] = std::clamp(phi_frozen_[i] + relaxation_ * phi_change_[i], phi.committed[i], 1.0);
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
      project_predictor(t_n, dt, u_tilde, v);
    };
  if (stabilise_ || !motion_.rigid().empty())
    hooks.correct = [this](TS, Vec u, Vec v, Vec a) {
      check(VecSet(contact_acceleration_, 0));
      if (stabilise_) take_out_contact(v, a);
      if (!motion_.rigid().empty()) take_out_rigidity(u, v, a);
    };
  return hooks;
}

void Coupling::take_out_contact(Vec v, Vec a) {
  PetscReal size = 0;
  check(VecNorm(contact_force_, NORM_INFINITY, &size));
  if (size == 0) return;
  const NewmarkParameters p = newmark_parameters(ts_);
  check(VecCopy(contact_force_, residual_));
  check(VecScale(residual_, contact_scale_ / p.alpha_m));
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
    check(SNESCreate(motion_.discretisation().mesh.comm(), snes.out()));
    check(SNESSetKSP(snes, projection_solver()));
    check(SNESSetFunction(snes, f, Projection::residual, &problem));
    check(SNESSetJacobian(snes, motion_.jacobian(), motion_.matrix(), Projection::tangent, &problem));
    check(SNESSetTolerances(snes, motion_.reference_force(), 1e-10, 1e-12, 25, PETSC_DEFAULT));
    // Full steps: the problem is convex, and a search for a smaller residual stalls where a point opens or
    // closes.
    SNESLineSearch search = nullptr;
    check(SNESGetLineSearch(snes, &search));
    check(SNESLineSearchSetType(search, SNESLINESEARCHBASIC));
    update_multipliers_in(snes);
    solving_ = snes;
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
