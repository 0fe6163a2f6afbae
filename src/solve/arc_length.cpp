#include <algorithm>
#include <cmath>
#include <impact/petsc/error.hpp>
#include <impact/petsc/field_solver.hpp>
#include <impact/solve/arc_length.hpp>

namespace impact {

ArcLength::ArcLength(MotionProblem& motion, NewtonHooks& hooks, StateTable& state,
                     const CouplingScenario& settings)
    : motion_(motion), hooks_(hooks), settings_(settings),
      row_(state.add({load_parameter_row, Support::global, 2}, 2)), rate_(state.row("mean_rate")),
      direction_(motion.discretisation().displacement.make_global()),
      start_(motion.discretisation().displacement.make_global()) {}

// The way back from a limit may raise the residual by any factor.
void ArcLength::install(SNES snes) {
  if (const std::string search = line_search_of(snes); search != SNESLINESEARCHBASIC)
    throw UserError(ExitCode::usage, "-motion_snes_linesearch_type " + search +
                                         ": not with -ts_path_length, whose steps are full ones (basic); "
                                         "leave it out");
  check(SNESSetDivergenceTolerance(snes, -1));
  check(SNESLineSearchSetPreCheck(Get(SNESGetLineSearch)(snes), Callback<&ArcLength::border>::call, this));
}

double ArcLength::length() const { return settings_.path_length * motion_.step().dt / settings_.dt; }

void ArcLength::go_ahead(Vec u, double growth) {
  check(VecScale(direction_, 1 / Get(VecNorm)(direction_, NORM_INFINITY)));
  const PetscReal size = Get(VecNorm)(direction_, NORM_2);
  far_ = length() * size * size;
  check(VecWAXPY(u, length(), direction_, start_));
  go_to_load(motion_, start() + length() * growth);
  motion_.impose(u);
}

// As the step before went, cut or grown with this one.
bool ArcLength::predict(Vec u) {
  idle_ = false;
  const FieldLayout& layout = motion_.discretisation().displacement;
  layout.to_global(*motion_.step().u_n, start_);
  layout.to_global(rate_.committed, direction_);
  const PetscReal fastest = Get(VecNorm)(direction_, NORM_INFINITY);
  go_to_load(motion_, start());
  if (fastest > 0)
    go_ahead(u, row_.committed[1] / fastest);
  else
    check(VecCopy(start_, u));
  return fastest > 0;
}

bool ArcLength::set_out(SNES snes, Vec u, Vec residual) {
  if (!answer(snes, u, residual, direction_)) return false;
  const PetscReal moved = Get(VecNorm)(direction_, NORM_INFINITY);
  if (!(moved > 0))
    throw UserError(ExitCode::usage, "-ts_path_length: no condition moves or loads a body where t begins to "
                                     "grow; give one that does, as -bc_<id>_ux \"10*t\", or remove this");
  go_ahead(u, 1 / moved);
  return true;
}

// p = du/ds at u in balance, by a difference over a thousandth of what the load has changed by, or over less
// where prescribed nodes, which go along, would leave the linear range of slender bodies.
bool ArcLength::answer(SNES snes, Vec u, Vec residual, Vec p) {
  const FieldLayout& layout = motion_.discretisation().displacement;
  const double load = motion_.step().t, change = std::abs(load - start()),
               small = 1e-7 * motion_.discretisation().mesh.smallest_edge();
  double part = 1e-3 * (change > 0 ? change : settings_.dt);
  const Handle<Vec> there = layout.make_global(), r = layout.make_global();
  PetscReal ahead = 0;
  for (int looks = 0; looks == 0 || (looks < 4 && ahead > 2 * small); ++looks) { // conditions may jump
    if (looks > 0) part *= small / ahead;
    check(VecCopy(u, there));
    go_to_load(motion_, load + part);
    motion_.impose(there);
    check(VecWAXPY(r, -1, u, there));
    ahead = Get(VecNorm)(r, NORM_INFINITY);
  }
  const bool sound = motion_.residual(there, nullptr, r);
  go_to_load(motion_, load);
  check(VecAXPY(r, -1, residual));
  const KSP ksp = Get(SNESGetKSP)(snes);
  hooks_.conduct.alone = true;
  check(KSPSolve(ksp, r, p));
  hooks_.conduct.alone = false;
  check(VecAXPBYPCZ(p, 1, -1, -1, there, u)); // whose rows of prescribed dofs are zero
  check(VecScale(p, 1 / part));
  idle_ = !(Get(VecNorm)(p, NORM_INFINITY) > 0);
  return sound && Get(KSPGetConvergedReason)(ksp) >= 0;
}

// u = x - y solves the linearised balance at the present load: u + ds p does at the load s + ds, where it is
// as far along the direction as the step asks.
void ArcLength::border(SNESLineSearch search, Vec x, Vec y, PetscBool* changed) {
  const FieldLayout& layout = motion_.discretisation().displacement;
  SNES snes = nullptr;
  Vec residual = nullptr;
  check(SNESLineSearchGetSNES(search, &snes));
  check(SNESGetFunction(snes, &residual, nullptr, nullptr));
  const Handle<Vec> p = layout.make_global(), end = layout.make_global();
  if (!answer(snes, x, residual, p) || idle_) return; // and `settle` sees it
  check(VecWAXPY(end, -1, y, x));
  const PetscReal gone = Get(VecDot)(direction_, end) - Get(VecDot)(direction_, start_),
                  rate = Get(VecDot)(direction_, p), more = (far_ - gone) / rate;
  if (!std::isfinite(more)) return;
  check(VecAXPY(end, more, p));
  go_to_load(motion_, motion_.step().t + more);
  motion_.impose(end);
  check(VecWAXPY(y, -1, end, x));
  *changed = PETSC_TRUE;
}

bool ArcLength::settle(Vec u) {
  constexpr double exact = 1e-6;
  const double load = motion_.step().t, gone = Get(VecDot)(direction_, u) - Get(VecDot)(direction_, start_);
  row_.trial = {load, (load - start()) / motion_.step().dt};
  return std::abs(gone - far_) <= exact * far_;
}

std::string ArcLength::trouble() const {
  return idle_ ? text_of("no condition changes with t at load_parameter %.6g", motion_.step().t) : "";
}

} // namespace impact
