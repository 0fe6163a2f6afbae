#include <algorithm>
#include <cmath>
#include <impact/petsc/error.hpp>
#include <impact/petsc/field_solver.hpp>
#include <impact/petsc/slope_search.hpp>
#include <petsc/private/linesearchimpl.h>
#include <petsc/private/snesimpl.h>

namespace impact {

namespace {

PetscReal& least_norm(SNESLineSearch search) { return *static_cast<PetscReal*>(search->data); }

/// The line x - lambda y of one search, at whose start the residual is f.
class Line {
public:
  explicit Line(SNESLineSearch search) : snes_(search->snes), least_(least_norm(search)) {
    check(SNESLineSearchGetVecs(search, &x_, &f_, &y_, &w_, &g_));
    least_ = snes_->iter == 0 ? search->fnorm : std::min(least_, search->fnorm);
    first_ = Get(VecDot)(f_, y_);
  }
  double lambda() const { return lambda_; }
  /// By how much the energy descends with lambda, there and at the start; 0 where it has no value.
  double slope() const { return slope_; }
  double first() const { return first_; }
  void look_at(double lambda) {
    lambda_ = lambda;
    check(VecWAXPY(w_, -lambda, y_, x_));
    check(SNESComputeFunction(snes_, w_, g_));
    norm_ = Get(VecNorm)(g_, NORM_2);
    snes_->domainerror = PETSC_FALSE; // it made the norm infinite
    sound_ = std::isfinite(norm_);
    slope_ = sound_ ? Get(VecDot)(g_, y_) : 0;
  }
  bool sound() const { return sound_; }
  bool halves() const { return sound_ && norm_ <= 0.5 * least_; }
  void turn() {
    check(VecScale(y_, -1));
    first_ = -first_;
  }

private:
  SNES snes_;
  PetscReal& least_; // of the iterates of the solve: what halves it cannot come round again
  Vec x_, f_, y_, w_, g_;
  double first_, lambda_ = 0, norm_ = 0, slope_ = 0;
  bool sound_ = true;
};

// The energy descends at `low` and rises at `high`, or has no value there. Nothing is gained by steps to the
// edge of where it has one, nor by longer ones than Newton's, nor, where springs close, by those below the
// shortest: they close one after the other.
bool search_along(Line& line, double lambda, double shortest, PetscInt most) {
  line.look_at(lambda);
  if (line.first() < 0 && !line.halves()) {
    line.turn();
    line.look_at(lambda);
  }
  double low = 0, low_slope = line.first(), high_slope = 0, high = lambda;
  for (PetscInt looks = 1; looks <= most; ++looks) {
    const bool level = line.sound() && std::abs(line.slope()) <= 0.5 * line.first(),
               descends = line.sound() && line.slope() > 0;
    if (line.halves() || level || (descends && high_slope == 0)) return true;
    (descends ? low : high) = line.lambda();
    (descends ? low_slope : high_slope) = line.slope();
    if (line.sound() && line.lambda() < shortest) return true;
    const double secant = low_slope / (low_slope - high_slope);
    line.look_at(low + (high_slope < 0 ? std::clamp(secant, 0.1, 0.8) : 0.5) * (high - low));
  }
  return line.sound();
}

void apply(SNESLineSearch search) {
  Vec x = nullptr, f = nullptr, y = nullptr, w = nullptr, g = nullptr;
  PetscBool changed_y = PETSC_FALSE, changed_w = PETSC_FALSE;
  check(SNESLineSearchGetVecs(search, &x, &f, &y, &w, &g));
  check(SNESLineSearchSetReason(search, SNES_LINESEARCH_SUCCEEDED));
  check(SNESLineSearchPreCheck(search, x, y, &changed_y));
  Line line(search);
  const PetscReal longest = search->maxstep / std::max(Get(VecNorm)(y, NORM_2), PETSC_MACHINE_EPSILON);
  const bool found = search_along(line, std::min(search->lambda, longest), search->steptol, search->max_its);
  search->lambda = line.lambda();
  if (search->monitor != nullptr)
    check(PetscViewerASCIIPrintf(search->monitor, "      Line search: lambda = %g, slope %g after %g\n",
                                 line.lambda(), line.slope(), line.first()));
  if (!found) return check(SNESLineSearchSetReason(search, SNES_LINESEARCH_FAILED_REDUCT));
  check(SNESLineSearchPostCheck(search, x, y, w, &changed_y, &changed_w));
  if (changed_y) check(VecWAXPY(w, -search->lambda, y, x));
  if (changed_y || changed_w) check(SNESComputeFunction(search->snes, w, g));
  check(VecCopy(w, x));
  check(VecCopy(g, f));
  check(SNESLineSearchComputeNorms(search));
}

PetscErrorCode create(SNESLineSearch search) {
  search->ops->apply = [](SNESLineSearch made) { return guarded([&] { apply(made); }); };
  search->ops->destroy = [](SNESLineSearch made) -> PetscErrorCode {
    delete &least_norm(made);
    return 0;
  };
  search->data = new PetscReal(0);
  search->max_its = 20;
  return 0;
}

} // namespace

void register_slope_search() { check(SNESLineSearchRegister(slope_search_type, create)); }

} // namespace impact
