#include <algorithm>
#include <cmath>
#include <impact/petsc/error.hpp>
#include <impact/petsc/field_solver.hpp>
#include <impact/solve/newton_hooks.hpp>
#include <impact/time/types.hpp>
#include <petsc/private/snesimpl.h>
#include <string_view>

namespace impact {

namespace {

// A residual within this multiple of its tolerance is near the solution.
constexpr double near_balance = 10;

bool alike(double a, double b, double part) { return std::abs(a - b) <= part * std::max(a, b); }

// Decimal digits that a solve is to reduce its residual by.
double decades_of(KSP ksp) {
  PetscReal rtol = 0;
  check(KSPGetTolerances(ksp, &rtol, nullptr, nullptr, nullptr));
  return -std::log10(rtol);
}

// Of Cholesky factors, which MUMPS counts.
bool has_negative_pivots(KSP ksp) {
  const PC pc = Get(KSPGetPC)(ksp);
  MatSolverType package = nullptr;
  check(PCFactorGetMatSolverType(pc, &package));
  PetscInt negative = 0;
  if (has_type(pc, PCCHOLESKY) && package == std::string_view(MATSOLVERMUMPS))
    check(MatMumpsGetInfog(Get(PCFactorGetMatrix)(pc), 12, &negative));
  return negative > 0;
}

} // namespace

void NewtonWatch::start(bool full_steps) {
  full_steps_ = full_steps;
  unchanged_ = short_ = risen_ = 0;
  norms_.clear();
  active_.clear();
  set_ = 0;
}

void NewtonWatch::note_step(double part) { short_ = part < 0.5 ? short_ + 1 : 0; }

void NewtonWatch::note(double norm) {
  const bool near =
      is_near(norm); // far from the solution an active set that grows by a node at a time looks the same
  const double last = norms_.empty() ? 0 : norms_.back();
  const bool other_set = !active_.empty() && active_.back() != set_;
  const bool lingers = norm < 1.1 * last && norm > last * (near ? 2. / 3 : 0.9);
  unchanged_ = lingers && !other_set ? unchanged_ + 1 : 0;
  risen_ = !norms_.empty() && norm > 1.5 * last ? risen_ + 1 : 0;
  norms_.push_back(norm);
  active_.push_back(set_);
}

int NewtonWatch::cycle() const {
  constexpr std::size_t longest = 6, least_compared = 4;
  const std::size_t n = norms_.size();
  for (std::size_t period = 2; period <= longest; ++period) {
    const std::size_t compared = std::max(period, least_compared);
    if (n < period + compared) return 0;
    const auto last = norms_.end() - static_cast<std::ptrdiff_t>(compared);
    const bool repeats = std::equal(last, norms_.end(), last - static_cast<std::ptrdiff_t>(period),
                                    [](double a, double b) { return alike(a, b, 0.04); });
    const auto [low, high] =
        std::minmax_element(norms_.end() - static_cast<std::ptrdiff_t>(period), norms_.end());
    const auto sets = active_.end() - static_cast<std::ptrdiff_t>(compared),
               before = sets - static_cast<std::ptrdiff_t>(period);
    if (repeats && std::equal(sets, active_.end(), before) && !alike(*low, *high, 0.1))
      return static_cast<int>(period);
  }
  return 0;
}

bool TangentReuse::serves(SNES snes, PetscReal dt, PetscReal shift) {
  if (reduction_ <= 0) return false;
  const PetscInt iteration = Get(SNESGetIterationNumber)(snes);
  const PetscReal norm = Get(SNESGetFunctionNorm)(snes);
  // A solve's first iteration tries the tangent of the solve before: its reduction is known only afterwards.
  const bool reduces = iteration == 0 || norm <= reduction_ * norm_;
  const bool serves = valid_ && dt == dt_ && shift == shift_ && reduces;
  valid_ = true;
  dt_ = dt;
  shift_ = shift;
  norm_ = norm;
  return serves;
}

std::string line_search_of(SNES snes) {
  const SNESLineSearch search = Get(SNESGetLineSearch)(snes);
  const SNESLineSearchType type = Get(SNESLineSearchGetType)(search);
  return type ? type : "";
}

NewtonHooks::NewtonHooks(TS ts, MotionProblem& motion, LooseBodies& loose, TangentReuse& reuse)
    : motion_(motion), loose_(loose), reuse_(reuse), mailbox_(time_mailbox(ts)),
      bare_residual_(motion.discretisation().displacement.make_global()) {}

void NewtonHooks::install(SNES snes) {
  linear_.snes = snes;
  // The first multipliers, or the first touch of a body that lay free, may raise the norm of a residual that
  // was nearly zero by any factor.
  if (motion_.contacts().demands().closes_gaps || !loose_.empty())
    check(SNESSetDivergenceTolerance(snes, -1));
  const SNESLineSearch search = Get(SNESGetLineSearch)(snes);
  check(SNESLineSearchSetPostCheck(search, Callback<&NewtonHooks::after_step>::call, this));
  const KSP ksp = Get(SNESGetKSP)(snes);
  check(KSPGetTolerances(ksp, &linear_.rtol, nullptr, nullptr, &linear_.most));
  check(KSPSetPreSolve(ksp, Callback<&NewtonHooks::before_linear_solve>::call, this));
  check(KSPSetPostSolve(ksp, Callback<&NewtonHooks::after_linear_solve>::call, this));
  check(KSPMonitorSet(ksp, Callback<&NewtonHooks::count>::call, this, nullptr));
  check(SNESSetConvergenceTest(snes, Callback<&NewtonHooks::test>::call, this, nullptr));
}

// The step y led from x to the iterate w, where the residual is evaluated next.
void NewtonHooks::after_step(SNESLineSearch search, Vec x, Vec y, Vec w, PetscBool*, PetscBool* changed) {
  const ContactDemands demands = motion_.contacts().demands();
  const bool rigid = !motion_.rigid().empty();
  if (at_kink(search, x, y, w)) {
    check(VecWAXPY(w, -1, y, x));
    *changed = PETSC_TRUE;
  }
  if (conduct.patience > 0) watch_.note_step(part_of(x, y, w));
  motion_.foretell(x, w);
  if (!demands.closes_gaps && !rigid && !demands.frictional && loose_.empty()) return;
  if (const double part = loose_.empty() ? 1 : loose_.part_of(y); part < 1 && part < part_of(x, y, w)) {
    check(VecWAXPY(w, -part, y, x));
    *changed = PETSC_TRUE;
  }
  if (demands.reverses) {
    check(VecWAXPY(w, -1, y, x));
    *changed = PETSC_TRUE;
  }
  // Not w, unless a body turned, but the residual there.
  if (demands.closes_gaps || demands.frictional || rigid) *changed = PETSC_TRUE;
  const Handle<Vec> step = motion_.discretisation().displacement.make_global();
  check(VecWAXPY(step, -1, x, w));
  motion_.rigid().retract(w);
  const SetChange set = motion_.contacts().after_newton_step(x, step, w, conduct.follows_sliding);
  if (set.other) reuse_.forget();
  motion_.balance().note_set(set.other);
  watch_.note_set(set.active);
}

// Where points of contact close or open, the norm along a step may be smallest at its start however good its
// end is. Near the solution such a step goes all the way.
bool NewtonHooks::at_kink(SNESLineSearch search, Vec x, Vec y, Vec w) const {
  const std::string type = Get(SNESLineSearchGetType)(search);
  if (motion_.contacts().empty() || type != SNESLINESEARCHL2 || !watch_.is_near()) return false;
  return part_of(x, y, w) < 0.1;
}

// The search tells its length only afterwards.
double NewtonHooks::part_of(Vec x, Vec y, Vec w) const {
  const Handle<Vec> step = motion_.discretisation().displacement.make_global();
  check(VecWAXPY(step, -1, x, w));
  return Get(VecNorm)(step, NORM_2) / Get(VecNorm)(y, NORM_2);
}

bool NewtonHooks::closes_gaps() const {
  const ContactDemands demands = motion_.contacts().demands();
  return demands.closes_gaps || demands.reverses;
}

// SNES's forcing terms stand where these hooks do, which therefore call them.
void NewtonHooks::before_linear_solve(KSP ksp, Vec rhs, Vec du) {
  linear_.stopped = 0;
  const bool serves = preconditioner.serves();
  check(KSPSetReusePreconditioner(ksp, serves ? PETSC_TRUE : PETSC_FALSE));
  if (!linear_.is_retried && !conduct.alone) check(KSPPreSolve_SNESEW(ksp, rhs, du, linear_.snes));
  const PetscInt most = serves ? std::min(linear_.most, preconditioner.most(decades_of(ksp))) : linear_.most;
  check(KSPSetTolerances(ksp, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT, most));
  if (linear_.is_retried) return;
  if (conduct.known && !has_type(ksp, KSPPREONLY)) {
    check(VecCopy(conduct.known, du));
    check(KSPSetInitialGuessNonzero(ksp, PETSC_TRUE));
  }
  if (!closes_gaps()) return;
  check(VecCopy(rhs, bare_residual_));
  add_gaps(conduct.iterate, rhs);
}

void NewtonHooks::after_linear_solve(KSP ksp, Vec rhs, Vec du) {
  if (linear_.is_retried) return;
  const KSPConvergedReason reason = Get(KSPGetConvergedReason)(ksp);
  const bool indefinite = reason == KSP_DIVERGED_INDEFINITE_MAT || reason == KSP_DIVERGED_INDEFINITE_PC;
  conduct.indefinite = indefinite || has_negative_pivots(ksp);
  if (reason < 0 && linear_.stopped == 0 && (preconditioner.serves() || indefinite))
    repeat(ksp, rhs, du, indefinite);
  if (Get(KSPGetConvergedReason)(ksp) < 0)
    preconditioner.forget();
  else
    preconditioner.note(Get(KSPGetIterationNumber)(ksp), decades_of(ksp));
  if (conduct.known) check(KSPSetInitialGuessNonzero(ksp, PETSC_FALSE));
  conduct.known = {};
  if (!conduct.alone) check(KSPPostSolve_SNESEW(ksp, rhs, du, linear_.snes));
  check(KSPSetTolerances(ksp, linear_.rtol, PETSC_DEFAULT, PETSC_DEFAULT, linear_.most));
  if (closes_gaps()) check(VecCopy(bare_residual_, rhs));
  motion_.rigid().expand(conduct.iterate, du);
}

void NewtonHooks::count(KSP ksp, PetscInt iterations, PetscReal) {
  if (iterations == 0 || !conduct.too_many || !conduct.too_many(iterations)) return;
  linear_.stopped = iterations;
  check(KSPSetTolerances(ksp, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT, iterations));
}

// With a new preconditioner; where a crack opens or a body buckles the tangent may be indefinite, for which
// conjugate gradients are not made. A Newton step from there is worth no more than three digits.
void NewtonHooks::repeat(KSP ksp, Vec rhs, Vec du, bool indefinite) {
  const std::string krylov = Get(KSPGetType)(ksp);
  preconditioner.forget();
  linear_.in_vain += Get(KSPGetIterationNumber)(ksp);
  if (indefinite) {
    check(KSPSetType(ksp, KSPGMRES));
    check(KSPGMRESSetRestart(ksp, 100));
    check(KSPSetTolerances(ksp, std::max(1e-3, std::pow(10, -decades_of(ksp))), PETSC_DEFAULT, PETSC_DEFAULT,
                           PETSC_DEFAULT));
  }
  linear_.is_retried = true;
  check(KSPSolve(ksp, rhs, du));
  linear_.is_retried = false;
  if (indefinite) check(KSPSetType(ksp, krylov.c_str()));
}

void NewtonHooks::add_gaps(Vec u, Vec f) {
  Vec gaps = f;
  Handle<Vec> apart; // the residual holds forces on rigid bodies already as those on their unknowns
  if (!motion_.rigid().empty()) {
    apart = motion_.discretisation().displacement.make_global();
    gaps = apart;
  }
  for (const ContactInterface& contact : motion_.contacts())
    contact.add_gaps(u, motion_.step().contact.scale, gaps);
  if (!apart) return;
  motion_.rigid().reduce(u, apart);
  check(VecAXPY(f, 1, apart));
}

void NewtonHooks::test(SNES snes, PetscInt it, PetscReal, PetscReal, PetscReal norm,
                       SNESConvergedReason* reason) {
  ForceBalance& balance = motion_.balance();
  if (it == 0) {
    if (!conduct.goes_on) balance.start();
    balance.aim(conduct.aim);
    balance.note_set(false);
    watch_.start(line_search_of(snes) == SNESLINESEARCHBASIC);
    near_ = 0;
    open_ = HUGE_VAL;
  }
  watch_.note(norm);
  *reason = balance.test(snes, it, norm);
  const Vec u = Get(SNESGetSolution)(snes);
  if (motion_.contacts().demands().closes_gaps && balance.ratio() <= near_balance && !gaps_settle(u) &&
      *reason > 0)
    *reason = SNES_CONVERGED_ITERATING;
  if (*reason != SNES_CONVERGED_ITERATING) return;
  // Of a first touch, which goes on once pairs have been looked for.
  if (it > 0 && conduct.aim == Aim::thousandth && loose_.must_look()) *reason = SNES_DIVERGED_MAX_IT;
  conduct.hurried = conduct.patience > 0 && watch_.cut_steps() >= conduct.patience;
  if (conduct.hurried || (conduct.watched && gives_up())) *reason = SNES_DIVERGED_LOCAL_MIN;
}

// Whether nothing is left open that another iteration closes.
bool NewtonHooks::gaps_settle(Vec u) {
  const double before = open_;
  const auto [closed, open] = motion_.contacts().gaps_left(u, motion_.balance().force());
  open_ = open;
  return closed || (open_ > before / 2 && open_ <= most_open);
}

bool NewtonHooks::gives_up() {
  // Newton's method passes the last decade in an iteration or two, unless rounding is as large, or there are
  // more constraints than the surfaces can meet: no pressure closes the gaps that they leave.
  constexpr int most_near = 6;
  if (conduct.aim == Aim::balance && motion_.balance().ratio() <= near_balance) ++near_;
  return watch_.cycle() > 0 || watch_.stalls() || watch_.leaves() || near_ >= most_near;
}

} // namespace impact
