#include <algorithm>
#include <cmath>
#include <impact/petsc/error.hpp>
#include <impact/petsc/field_solver.hpp>
#include <impact/petsc/log.hpp>
#include <impact/problem/coupling.hpp>
#include <impact/time/types.hpp>

/// Newton's method for the motion at a given phi and theta: its hooks for contact, its first iteration, when
/// it gives up and how it is tried again (src/theory.md, 7).
namespace impact {

namespace {

// A residual within this multiple of its tolerance is near the solution.
constexpr double near_balance = 10;

} // namespace

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
          if (self.motion_.contacts().after_newton_step(x, step, w, self.first_way_)) self.reuse_.forget();
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
  motion_.contacts().add_gaps(u, step_.contact_scale, gaps);
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
  motion_.contacts().start_newton(u);
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
    motion_.contacts().after_newton_step(start, other, u, false);
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
  const GapsLeft left = motion_.contacts().gaps_left(u, motion_.balance().force());
  open_ = left.open;
  return left.closed || (open_ > before / 2 && open_ <= most_open);
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
  motion_.contacts().fall_back();
  check(VecCopy(newton_start_, u));
  motion_.contacts().start_newton(u);
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
  return motion_.balance().holds() && motion_.contacts().gaps_left(u, motion_.balance().force()).closed;
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

} // namespace impact
