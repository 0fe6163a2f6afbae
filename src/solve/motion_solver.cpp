#include <algorithm>
#include <cmath>
#include <impact/petsc/error.hpp>
#include <impact/petsc/field_solver.hpp>
#include <impact/petsc/slope_search.hpp>
#include <impact/solve/motion_solver.hpp>
#include <impact/time/types.hpp>
#include <string_view>
#include <utility>

namespace impact {

namespace {

PetscInt most_of(SNES snes) {
  PetscInt most = 0;
  check(SNESGetTolerances(snes, nullptr, nullptr, nullptr, &most, nullptr));
  return most;
}

void set_tolerances(SNES snes, PetscReal rtol, PetscInt most) {
  check(SNESSetTolerances(snes, PETSC_DEFAULT, rtol, PETSC_DEFAULT, most, PETSC_DEFAULT));
}

// Where springs of contacts close, a search that takes shorter steps closes them one after the other. It goes
// no farther down than that; options still say otherwise.
constexpr PetscReal shortest_beside_contact = 0.1;

/// Returns the one of before. One that is given stays.
PetscReal set_shortest_step(SNESLineSearch search) {
  PetscReal before = 0;
  check(SNESLineSearchGetTolerances(search, &before, nullptr, nullptr, nullptr, nullptr, nullptr));
  if (constexpr PetscReal of_petsc = 1e-12; before == of_petsc)
    check(SNESLineSearchSetTolerances(search, shortest_beside_contact, PETSC_DEFAULT, PETSC_DEFAULT,
                                      PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  return before;
}

LooseBodies loose_bodies(TS ts, MotionProblem& motion) {
  if (integrator_of(ts).inertia) return {};
  return {motion.discretisation(), motion.boundary(), motion.contacts(), motion.rigid()};
}

} // namespace

MotionSolver::MotionSolver(TS ts, MotionProblem& motion, const SolverDefaults& defaults,
                           const CouplingScenario& settings, StateTable& state)
    : ts_(ts), motion_(motion), loose_(loose_bodies(ts, motion)), hooks_(ts, motion, loose_, reuse_),
      defaults_(defaults), settings_(settings),
      factors_(state.add({"motion_factors", Support::global, 1}, 1)),
      residual_(motion.discretisation().displacement.make_global()),
      start_(motion.discretisation().displacement.make_global()) {
  if (settings_.path_length > 0) arc_.emplace(motion_, hooks_, state, settings_);
  check(SNESCreate(motion_.discretisation().mesh.comm(), snes_.out()));
  check(SNESSetOptionsPrefix(snes_, "motion_"));
  check(SNESSetFunction(snes_, residual_, Callback<&MotionSolver::residual>::call, this));
  refresh_matrix();
  const SNESLineSearchType search = line_search();
  // A front of slip passes a node or two an iteration, however short the step: 70 in a belt of 180 facets
  // (dual multipliers), 125 in a strip of 100 (shape functions). So does the end of what touches along
  // slender bodies that lie on each other: 80 in leaves of 90 facets.
  const ContactDemands demands = motion_.contacts().demands();
  const PetscInt most = demands.frictional || demands.closes_gaps       ? 150
                        : search == std::string_view(slope_search_type) ? 50
                                                                        : 25;
  check(SNESSetTolerances(snes_, motion_.reference_force(), 1e-10, 0, most, PETSC_DEFAULT));
  set_motion_solver(snes_, defaults, search, motion_.jacobian() != motion_.matrix());
  if (!motion_.contacts().empty() && line_search_of(snes_) == slope_search_type)
    set_shortest_step(Get(SNESGetLineSearch)(snes_));
  check(SNESGetTolerances(snes_, nullptr, &rtol_, nullptr, nullptr, nullptr));
  hooks_.conduct.too_many = [this](PetscInt iterations) { return take_longer_than_factors(iterations); };
  install_hooks();
  choose_reuse();
}

void MotionSolver::install_hooks() {
  hooks_.install(snes_);
  if (arc_) arc_->install(snes_);
}

// With multipliers among the unknowns the full step is what makes the chosen set of gaps vanish, and friction
// has no energy. Rigid bodies turn without one, and a path has none past its limits. Elsewhere the norm has
// minima that are no solutions: where a crack runs, or where springs of contact are far stiffer than bodies.
SNESLineSearchType MotionSolver::line_search() const {
  const ContactDemands demands = motion_.contacts().demands();
  if (demands.closes_gaps || demands.frictional || !loose_.empty() || arc_) return SNESLINESEARCHBASIC;
  return motion_.rigid().empty() ? slope_search_type : SNESLINESEARCHL2;
}

Mailbox& MotionSolver::mailbox() { return time_mailbox(ts_); }

PetscInt MotionSolver::most_iterations() const { return most_of(snes_); }

Vec MotionSolver::left() const {
  Vec left = nullptr;
  check(SNESGetFunction(snes_, &left, nullptr, nullptr));
  return left;
}

void MotionSolver::residual(SNES, Vec u, Vec f) {
  const Vec a = rates_at(ts_, u).a_m;
  if (motion_.residual(u, integrator_of(ts_).inertia ? a : nullptr, f)) return;
  cell_broke_ = true;
  check(SNESSetFunctionDomainError(snes_));
}

void MotionSolver::tangent(SNES, Vec u, Mat, Mat) {
  const PetscReal mass_shift = rates_at(ts_, u).da_du;
  if (!loose_.empty()) {
    loose_.weigh(u, left());
    if (loose_.unbalanced()) reuse_.forget();
  }
  if (reuse_.serves(snes_, motion_.step().dt, mass_shift)) return;
  tangents_ += 1;
  const bool sound = motion_.tangent(u, mass_shift);
  if (!loose_.empty()) loose_.add_to(motion_.matrix());
  if (sound) return;
  reuse_.forget();
  cell_broke_ = true;
  check(SNESSetJacobianDomainError(snes_));
}

void MotionSolver::refresh_matrix() {
  reuse_.forget();
  check(SNESSetJacobian(snes_, motion_.jacobian(), motion_.matrix(), Callback<&MotionSolver::tangent>::call,
                        this));
}

bool MotionSolver::refresh_contact(Vec u) {
  if (!motion_.update_contact(u)) return false;
  // Another pattern: a new matrix, and the solver's factors with it unless they serve on.
  if (!hooks_.preconditioner.serves()) forget_factors();
  refresh_matrix();
  return true;
}

void MotionSolver::begin_attempt(PetscInt number) {
  counts_ = {.longest = number > 1 ? counts_.longest : 0, .second_ways = counts_.second_ways};
  if (number <= 1) second_way_first_ = false;
  number_ = number;
  reuse_.forget();
  if (leaves_unstable() && has_type(Get(KSPGetPC)(Get(SNESGetKSP)(snes_)), PCCHOLESKY))
    hooks_.preconditioner.forget(); // pivots of the step before tell nothing of this one
  cell_broke_ = false;
  products_for_factors_ = 0; // of this try alone, so that restarts do as runs that go on
  use_factors(factors_.committed[0] > 0);
  loose_.start_attempt();
}

Handle<Vec> MotionSolver::imposed(Vec u) {
  Handle<Vec> goal = motion_.discretisation().displacement.make_global();
  check(VecCopy(u, goal));
  motion_.impose(goal);
  refresh_contact(goal);
  return goal;
}

PetscReal MotionSolver::atol() const {
  PetscReal atol = 0;
  check(SNESGetTolerances(snes_, &atol, nullptr, nullptr, nullptr, nullptr));
  return atol;
}

PetscReal MotionSolver::left_at(Vec u) {
  check(SNESComputeFunction(snes_, imposed(u), residual_));
  const PetscReal norm = Get(VecNorm)(residual_, NORM_2);
  return std::exchange(cell_broke_, false) ? HUGE_VAL : norm;
}

// Prescribed nodes that jump ahead of their neighbours leave the whole increment to one layer of cells, and a
// search for the smallest residual shortens the steps of slender bodies, whose linear answer stretches them
// before the next iteration turns it. So the first iteration stands at the guess, takes the prescribed nodes
// along and goes all the way.
bool MotionSolver::enter_step(Vec u, Vec goal) {
  if (arc_) return enter_path(u);
  const Discretisation& d = motion_.discretisation();
  const Handle<Vec> ahead = d.displacement.make_global();
  motion_.rigid().retract(u);
  check(VecWAXPY(ahead, -1, u, goal));
  const PetscReal largest = Get(VecNorm)(ahead, NORM_INFINITY);
  // A jump below that strains the layer by so little that its answer is linear too.
  const double small = 1e-7 * d.mesh.smallest_edge();
  if (largest <= small) check(VecCopy(goal, u));
  // What nothing holds yet has no such answer: its steps are limited ones (H3).
  const bool searches = has_type(Get(SNESGetLineSearch)(snes_), SNESLINESEARCHL2, slope_search_type);
  hooks_.conduct.goes_on = loose_.empty() && (largest > small || searches) &&
                           first_iteration(u, largest > small ? ahead.get() : nullptr, small / largest);
  if (!hooks_.conduct.goes_on) check(VecCopy(goal, u));
  return true;
}

bool MotionSolver::enter_path(Vec u) {
  if (arc_->predict(u)) return true;
  check(SNESComputeFunction(snes_, u, residual_));
  check(SNESComputeJacobian(snes_, u, motion_.jacobian(), motion_.matrix()));
  check(KSPSetOperators(Get(SNESGetKSP)(snes_), motion_.jacobian(), motion_.matrix()));
  return arc_->set_out(snes_, u, residual_);
}

// K_ff du_f = -r - K_fc du_c at u, where `ahead` is du_c, or null. False where there is nothing to do, or the
// answer is no better than the guess: the energy's slope along the step, zero at the end if all was linear,
// is still as large as at its start.
bool MotionSolver::first_iteration(Vec u, Vec ahead, double part) {
  const FieldLayout& layout = motion_.discretisation().displacement;
  refresh_contact(u);
  motion_.contacts().start_newton(u);
  const Handle<Vec> r = layout.make_global(), other = layout.make_global(), step = layout.make_global(),
                    start = layout.make_global();
  hooks_.conduct.iterate = u;
  tangents_ = 0;
  check(VecCopy(u, start));
  check(SNESComputeFunction(snes_, u, r));
  if (ahead != nullptr) add_jump(u, ahead, part, r);
  motion_.balance().start();
  motion_.balance().aim(Aim::balance);
  motion_.balance().judge(r, atol(), rtol_);
  if (cell_broke_ || motion_.balance().holds()) return cell_broke_ = false;
  const PetscReal norm = Get(VecNorm)(r, NORM_2);
  check(SNESSetSolution(snes_, u));   // monitors look at it
  check(SNESMonitor(snes_, 0, norm)); // that of the next iteration follows, under the number 0 too
  if (!linear_step(u, r, step) && !(fall_back_on_factors() && linear_step(u, r, step)))
    return cell_broke_ = false;
  check(VecAXPY(u, -1, step));
  motion_.impose(u);
  if (motion_.contacts().demands().closes_gaps) {
    check(VecWAXPY(other, -1, start, u));
    motion_.contacts().after_newton_step(start, other, u, false);
    return true;
  }
  check(SNESComputeFunction(snes_, u, other));
  const bool better = std::abs(Get(VecDot)(other, step)) < std::abs(Get(VecDot)(r, step));
  if (!better && ahead == nullptr) { // Newton's method asks for the same step
    hooks_.conduct.known = layout.make_global();
    check(VecCopy(step, hooks_.conduct.known));
  }
  if (cell_broke_ || !better) return cell_broke_ = false;
  if (Get(VecNorm)(other, NORM_2) > reuse_.reduction() * norm) reuse_.forget();
  return true;
}

// r += K_fc du_c: a difference of the residual over a small `part` of du_c, whatever makes it up.
void MotionSolver::add_jump(Vec u, Vec ahead, double part, Vec r) {
  const FieldLayout& layout = motion_.discretisation().displacement;
  const Handle<Vec> start = layout.make_global(), there = layout.make_global(), here = layout.make_global();
  check(VecCopy(u, start));
  check(VecAXPY(u, part, ahead));
  check(SNESComputeFunction(snes_, u, there));
  check(VecCopy(r, here));
  if (hooks_.closes_gaps()) {
    hooks_.add_gaps(u, there);
    hooks_.add_gaps(start, here);
  }
  check(VecCopy(start, u));
  check(VecAXPY(there, -1, here));
  check(VecAXPY(r, 1 / part, there));
}

bool MotionSolver::linear_step(Vec u, Vec r, Vec step) {
  check(SNESComputeJacobian(snes_, u, motion_.jacobian(), motion_.matrix()));
  const KSP ksp = Get(SNESGetKSP)(snes_);
  check(KSPSetOperators(ksp, motion_.jacobian(), motion_.matrix()));
  hooks_.conduct.alone = true;
  check(KSPSolve(ksp, r, step));
  hooks_.conduct.alone = false;
  counts_.newton += 1;
  counts_.linear += Get(KSPGetIterationNumber)(ksp) + hooks_.take_repeated();
  const bool solved = Get(KSPGetConvergedReason)(ksp) >= 0;
  if (!solved) forget_factors();
  return solved && !cell_broke_;
}

SNESConvergedReason MotionSolver::solve(Vec u, Aim aim, PetscInt most, bool second_way) {
  const PetscInt most_by_options = most_iterations();
  // Down an energy it arrives, if late: where cuts do not help, a step has more iterations in each try.
  if (line_search_of(snes_) == slope_search_type) most *= number_;
  const PetscReal rough = aim == Aim::tenth ? 0.1 : aim == Aim::thousandth ? 1e-3 : 0;
  set_tolerances(snes_, std::max(rtol_, rough), most);
  hooks_.conduct.aim = aim;
  check(VecCopy(u, start_));
  motion_.contacts().keep_multipliers();
  iterations_ = hooks_.conduct.goes_on ? 1 : 0;
  const bool contact = !motion_.contacts().empty(), other_way = has_second_way();
  SNESConvergedReason reason = SNES_DIVERGED_MAX_IT;
  if (!second_way_first_) {
    watch(true); // as long as another way is left what goes in circles ends
    reason = first_way(u, most);
    watch(false);
  }
  // Full steps after sets of gaps that change may leave where cells are sound.
  const bool lost =
      reason == SNES_DIVERGED_MAX_IT || reason == SNES_DIVERGED_DTOL || reason == SNES_DIVERGED_LOCAL_MIN ||
      (cell_broke_ && contact && line_search_of(snes_) == SNESLINESEARCHBASIC && iterations_ > 1);
  if (lost && other_way && second_way) {
    // With contact both ways together take no more than one may; what has nothing left for the second one
    // begins the next try of the step with it. Where cuts do not help it has some in each.
    const PetscInt least = motion_.step().dt < 0.2 * settings_.dt ? most / 3 : 0;
    if (const PetscInt rest = contact ? std::max(most - iterations_, least) : most; rest > 0) {
      counts_.second_ways += second_way_first_ ? 0 : 1;
      reason = other_ways(u, rest);
    }
    if (contact && iterations_ >= most && reason < 0) second_way_first_ = !second_way_first_;
  }
  if (reason > 0 && hooks_.conduct.indefinite && leaves_unstable()) leave_unstable(u, most);
  if (arc_ && reason > 0 && !arc_->settle(u)) reason = SNES_DIVERGED_LINE_SEARCH;
  counts_.longest = std::max(counts_.longest, iterations_);
  set_tolerances(snes_, rtol_, most_by_options);
  hooks_.conduct.aim = Aim::balance;
  return reason;
}

void MotionSolver::restart(Vec u) {
  cell_broke_ = false;
  check(VecCopy(start_, u));
}

void MotionSolver::begin_again(Vec u) {
  restart(u);
  motion_.contacts().start_newton(u);
}

bool MotionSolver::has_second_way() const {
  const std::string search = line_search_of(snes_);
  return !arc_ && !search.empty() && search != SNESLINESEARCHBT && search != slope_search_type;
}

// Where points close or open, or volume changes its sign in a crack, Newton may jump to and fro between two
// states however small the step. Backtracking does not let the residual rise, so it leaves such a cycle.
// Where friction alone holds bodies the norm has minima that are no solutions, and the way goes down the
// slope.
SNESConvergedReason MotionSolver::backtrack(Vec u, PetscInt most) {
  const std::string first = line_search_of(snes_);
  const SNESLineSearch search = Get(SNESGetLineSearch)(snes_);
  const ContactDemands demands = motion_.contacts().demands();
  const bool down_the_slope = !loose_.empty() && demands.frictional && !demands.closes_gaps;
  begin_again(u);
  reuse_.forget();
  check(SNESLineSearchSetType(search, down_the_slope ? slope_search_type : SNESLINESEARCHBT));
  const PetscReal before = down_the_slope ? set_shortest_step(search) : PETSC_DEFAULT;
  hooks_.conduct.follows_sliding = down_the_slope;
  const SNESConvergedReason reason = newton(u, most);
  hooks_.conduct.follows_sliding = false;
  check(SNESLineSearchSetType(search, first.c_str()));
  check(SNESLineSearchSetTolerances(search, before, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT,
                                    PETSC_DEFAULT, PETSC_DEFAULT));
  return reason;
}

// One SNESSolve of at most so many iterations, a first one among them where the solve goes on from that.
SNESConvergedReason MotionSolver::newton(Vec u, PetscInt most) {
  tangents_ = hooks_.conduct.goes_on ? 1 : 0;
  hooks_.conduct.iterate = u;
  set_tolerances(snes_, PETSC_DEFAULT, std::max<PetscInt>(most - tangents_, 0));
  loose_.start_solve();
  check(SNESSolve(snes_, nullptr, u));
  hooks_.conduct.goes_on = false;
  SNESConvergedReason reason = Get(SNESGetConvergedReason)(snes_);
  // Factors of a singular matrix must not serve the next solve; MUMPS ends the run where they do.
  if (reason == SNES_DIVERGED_LINEAR_SOLVE) forget_factors();
  const PetscInt iterations = Get(SNESGetIterationNumber)(snes_);
  const PetscInt linear = Get(SNESGetLinearSolveIterations)(snes_);
  // No reason but a residual within its tolerance counts. A line search that found none smaller may have met
  // its rounding, which the last tangent told.
  if (reason > 0 && !motion_.balance().holds()) reason = SNES_DIVERGED_LINE_SEARCH;
  if (reason == SNES_DIVERGED_LINE_SEARCH && !cell_broke_ && balanced(u))
    reason = SNES_CONVERGED_FNORM_RELATIVE;
  counts_.newton += iterations;
  counts_.linear += linear + hooks_.take_repeated();
  counts_.hardest = std::max(counts_.hardest, tangents_);
  iterations_ += iterations;
  return reason;
}

bool MotionSolver::balanced(Vec u) {
  PetscReal atol = 0, rtol = 0;
  check(SNESGetTolerances(snes_, &atol, &rtol, nullptr, nullptr, nullptr));
  check(SNESComputeFunction(snes_, u, residual_));
  motion_.balance().judge(residual_, atol, rtol);
  return motion_.balance().holds() && motion_.contacts().gaps_left(u, motion_.balance().force()).closed;
}

// What faces what is found between the Newton solves, so that a stride is one iteration.
void MotionSolver::approach(Vec u) {
  if (loose_.empty()) return;
  const PetscInt most = most_iterations();
  for (PetscInt stride = 0; stride < most && loose_.sees_only(u); ++stride) {
    const SNESConvergedReason reason = newton(u, 1);
    set_tolerances(snes_, PETSC_DEFAULT, most);
    if (reason != SNES_DIVERGED_MAX_IT) return;
    refresh_contact(u);
  }
}

} // namespace impact
