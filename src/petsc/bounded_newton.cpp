#include <algorithm>
#include <cmath>
#include <impact/petsc/bounded_newton.hpp>
#include <impact/petsc/field_solver.hpp>
#include <impact/petsc/handle.hpp>
#include <impact/petsc/preconditioner_reuse.hpp>
#include <petsc/private/kspimpl.h>
#include <petsc/private/pcimpl.h>
#include <petsc/private/snesimpl.h>

namespace impact {

namespace {

/// The quadratic model of an iterate x with residual f: its residual at s is r = f + A (s - x).
// Members beyond twelve: work vectors.
class Model {
public:
  void set_up(SNES snes);
  /// Starts at x with the residual f there; its norm without the rows that bounds hold. Collective.
  PetscReal start(Vec x, Vec f);
  /// The norm of all its rows.
  PetscReal whole() const { return whole_; }
  /// Moves s from there until that norm, which is snes->norm, is at most `target`; false where a linear solve
  /// fails. Collective.
  bool minimise(SNES snes, PetscReal target);
  Vec solution() const { return s_; }

private:
  PetscReal find_free();
  void set_operators(KSP ksp);
  bool solve_free(SNES snes, PetscReal rtol);
  void go();
  void sweep();
  static PetscErrorCode multiply(Mat shell, Vec x, Vec y);
  static PetscErrorCode keep_free(MatNullSpace, Vec x, void* model);

  Mat A_ = nullptr;
  Vec low_ = nullptr, high_ = nullptr;
  Handle<Mat> shell_, part_; // A of free rows and columns; the same entry by entry
  Handle<Vec> s_, r_, d_, trial_, moved_, masked_, w_, free_, diagonal_;
  PetscReal whole_ = 0;              // norm of the residual with the rows that bounds hold
  PetscReal held_ = 0, changed_ = 0; // rows at bounds, rows that came or went since the last look
  PetscReal rtol_ = 0;               // of the KSP, as the options say
  PreconditionerReuse reuse_{10};
};

PetscErrorCode Model::multiply(Mat shell, Vec x, Vec y) {
  return guarded([&] {
    void* context = nullptr;
    check(MatShellGetContext(shell, &context));
    const Model& model = *static_cast<Model*>(context);
    check(VecPointwiseMult(model.masked_, x, model.free_));
    check(MatMult(model.A_, model.masked_, y));
    check(VecPointwiseMult(y, y, model.free_));
  });
}

PetscErrorCode Model::keep_free(MatNullSpace, Vec x, void* model) {
  return VecPointwiseMult(x, x, static_cast<Model*>(model)->free_);
}

void Model::set_up(SNES snes) {
  PetscInt local = 0, global = 0;
  Handle<MatNullSpace> held;
  A_ = snes->jacobian;
  low_ = snes->xl;
  high_ = snes->xu;
  for (Handle<Vec>* vec : {&s_, &r_, &d_, &trial_, &moved_, &masked_, &w_, &free_, &diagonal_})
    check(VecDuplicate(snes->vec_sol, vec->out()));
  check(VecSet(free_, 1));
  check(VecGetLocalSize(s_, &local));
  check(VecGetSize(s_, &global));
  const MPI_Comm comm = PetscObjectComm(reinterpret_cast<PetscObject>(snes));
  check(MatCreateShell(comm, local, local, global, global, this, shell_.out()));
  for (MatOperation operation : {MATOP_MULT, MATOP_MULT_TRANSPOSE})
    check(MatShellSetOperation(shell_, operation, reinterpret_cast<void (*)()>(multiply)));
  // What a preconditioner answers in held rows is removed as if it was a null space.
  check(MatNullSpaceCreate(comm, PETSC_FALSE, 0, nullptr, held.out()));
  check(MatNullSpaceSetFunction(held, keep_free, this));
  check(MatSetNullSpace(shell_, held));
  check(KSPGetTolerances(snes->ksp, &rtol_, nullptr, nullptr, nullptr));
}

PetscReal Model::start(Vec x, Vec f) {
  check(VecCopy(x, s_));
  check(VecCopy(f, r_));
  return find_free();
}

// A row is held where a bound stops it and its residual presses on.
PetscReal Model::find_free() {
  double sums[4] = {0, 0, 0, 0}; // squares of the residual, rows held, rows changed, all squares
  {
    PetscInt size = 0;
    double* free = nullptr;
    check(VecGetLocalSize(s_, &size));
    check(VecGetArray(free_, &free));
    const Entries s(s_), r(r_), low(low_), high(high_);
    for (PetscInt i = 0; i < size; ++i) {
      const bool held = low[i] >= high[i] || (s[i] <= low[i] && r[i] > 0) || (s[i] >= high[i] && r[i] < 0);
      const double now = held ? 0 : 1;
      sums[0] += now * r[i] * r[i];
      sums[1] += 1 - now;
      sums[2] += now == free[i] ? 0 : 1;
      sums[3] += r[i] * r[i];
      free[i] = now;
    }
    check(VecRestoreArray(free_, &free));
  }
  check(MPI_Allreduce(MPI_IN_PLACE, sums, 4, MPI_DOUBLE, MPI_SUM,
                      PetscObjectComm(reinterpret_cast<PetscObject>(free_.get()))));
  held_ = sums[1];
  changed_ = sums[2];
  whole_ = std::sqrt(sums[3]);
  return std::sqrt(sums[0]);
}

// What prepares the solve for the free rows is made of all of them, and so serves whichever are free; a
// solver without iterations needs the exact part.
void Model::set_operators(KSP ksp) {
  if (held_ == 0 || !has_type(ksp, KSPPREONLY)) return check(KSPSetOperators(ksp, shell_, A_));
  if (part_)
    check(MatCopy(A_, part_, SAME_NONZERO_PATTERN));
  else
    check(MatDuplicate(A_, MAT_COPY_VALUES, part_.out()));
  check(MatGetDiagonal(A_, diagonal_));
  check(MatDiagonalScale(part_, free_, free_));
  check(MatDiagonalSet(part_, diagonal_, INSERT_VALUES));
  check(KSPSetOperators(ksp, shell_, part_));
}

// Hierarchies serve on until the iterations that they take beyond those of a new one have cost as much as
// making it.
bool Model::solve_free(SNES snes, PetscReal rtol) {
  const KSP ksp = snes->ksp;
  const bool hierarchy = has_type(ksp->pc, PCHYPRE, PCGAMG, PCML) && !has_type(ksp, KSPPREONLY);
  const bool serves = reuse_.serves() && hierarchy && ksp->pc->setupcalled;
  if (!serves) {
    reuse_.forget();
    set_operators(ksp);
  }
  check(KSPSetReusePreconditioner(ksp, serves ? PETSC_TRUE : PETSC_FALSE));
  check(KSPSetTolerances(ksp, rtol, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  if (ksp->pc->setupcalled == 0) check(VecSet(d_, 0)); // what is forgotten is no first guess either
  check(VecPointwiseMult(w_, r_, free_));
  check(VecScale(w_, -1));
  check(KSPSolve(ksp, w_, d_));
  check(VecPointwiseMult(d_, d_, free_));
  snes->linear_its += ksp->its;
  if (ksp->reason >= 0) {
    reuse_.note(ksp->its, -std::log10(rtol));
    return true;
  }
  reuse_.forget();
  return serves && solve_free(snes, rtol);
}

// s goes to the bounds of s + d, or less far where that does not lower the energy.
void Model::go() {
  for (int halvings = 0; halvings < 30; ++halvings) {
    PetscReal slope = 0, bend = 0;
    check(VecWAXPY(trial_, 1, d_, s_));
    check(VecPointwiseMax(trial_, trial_, low_));
    check(VecPointwiseMin(trial_, trial_, high_));
    check(VecWAXPY(moved_, -1, s_, trial_));
    check(MatMult(A_, moved_, w_));
    check(VecDotBegin(moved_, r_, &slope));
    check(VecDotBegin(moved_, w_, &bend));
    check(VecDotEnd(moved_, r_, &slope));
    check(VecDotEnd(moved_, w_, &bend));
    if (slope + bend / 2 <= 0) {
      check(VecCopy(trial_, s_));
      return check(VecAXPY(r_, 1, w_));
    }
    check(VecScale(d_, 0.5));
  }
}

// Symmetric sweeps over the rows of a rank: a held row is let go with its neighbours' new values, which moves
// the end of a held set by several rows at once.
void Model::sweep() {
  constexpr int sweeps = 3;
  Mat mine = A_;
  if (has_type(A_, MATMPIAIJ)) check(MatMPIAIJGetSeqAIJ(A_, &mine, nullptr, nullptr));
  if (!has_type(mine, MATSEQAIJ)) return;
  PetscInt rows = 0;
  const PetscInt *start = nullptr, *column = nullptr;
  PetscBool done = PETSC_FALSE;
  const double* a = nullptr;
  double *s = nullptr, *moved = nullptr;
  check(MatGetRowIJ(mine, 0, PETSC_FALSE, PETSC_FALSE, &rows, &start, &column, &done));
  check(MatSeqAIJGetArrayRead(mine, &a));
  check(MatGetDiagonal(A_, diagonal_));
  check(VecSet(moved_, 0));
  check(VecGetArray(s_, &s));
  check(VecGetArray(moved_, &moved));
  {
    const Entries r(r_), diagonal(diagonal_), low(low_), high(high_);
    const auto relax = [&](PetscInt i) {
      double rest = r[i];
      for (PetscInt k = start[i]; k < start[i + 1]; ++k) rest += a[k] * moved[column[k]];
      const double before = s[i];
      s[i] = std::max(low[i], std::min(high[i], before - rest / diagonal[i]));
      moved[i] += s[i] - before;
    };
    for (int k = 0; k < sweeps; ++k) {
      for (PetscInt i = 0; i < rows; ++i) relax(i);
      for (PetscInt i = rows; i-- > 0;) relax(i);
    }
  }
  check(VecRestoreArray(moved_, &moved));
  check(VecRestoreArray(s_, &s));
  check(MatSeqAIJRestoreArrayRead(mine, &a));
  check(MatRestoreRowIJ(mine, 0, PETSC_FALSE, PETSC_FALSE, &rows, &start, &column, &done));
  check(MatMult(A_, moved_, w_));
  check(VecAXPY(r_, 1, w_));
}

bool Model::minimise(SNES snes, PetscReal target) {
  constexpr int most = 200;
  constexpr PetscReal rough = 0.5; // while the free set is not the last one
  bool settled = held_ == 0, converged = true;
  PetscReal norm = snes->norm, before = HUGE_VAL;
  target = std::max(target, rtol_ * norm);
  if (held_ != 0 && norm > target) {
    sweep();
    norm = find_free();
    settled = changed_ == 0;
  }
  for (int k = 0; k < most && converged && norm > target; ++k) {
    if (settled && norm > before / 2) break; // rounding
    before = settled ? norm : HUGE_VAL;
    const PetscReal rest = std::min(target / norm / 2, rough);
    converged = solve_free(snes, settled ? rest : rough);
    if (converged) go();
    norm = find_free();
    settled = changed_ == 0;
    if (held_ == 0 || norm <= target) continue;
    sweep();
    norm = find_free();
    settled = settled && changed_ == 0;
  }
  check(KSPSetTolerances(snes->ksp, rtol_, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  return converged;
}

void clip(SNES snes, Vec x) {
  check(VecPointwiseMax(x, x, snes->xl));
  check(VecPointwiseMin(x, x, snes->xu));
}

// Tells all who watch, and asks whether the solve has ended. The first call, with the norm of the whole
// residual, is what the relative tolerance refers to.
void judge(SNES snes, PetscReal norm, PetscReal whole) {
  snes->norm = norm;
  check(SNESLogConvergenceHistory(snes, norm, snes->linear_its));
  check(SNESMonitor(snes, snes->iter, norm));
  if (snes->domainerror) {
    snes->domainerror = PETSC_FALSE;
    snes->reason = SNES_DIVERGED_FUNCTION_DOMAIN;
    return;
  }
  check(snes->ops->converged(snes, snes->iter, 0, 0, norm, &snes->reason, snes->cnvP));
  if (snes->iter > 0) return;
  snes->rnorm0 = whole;
  snes->ttol = snes->rtol * whole;
  if (!snes->reason && norm <= snes->ttol) snes->reason = SNES_CONVERGED_FNORM_RELATIVE;
}

/// A tangent that is bent up (theory.md, 8) leaves iterates that come closer by the same factor rho each
/// time: the rest of their way, rho/(1 - rho) times the last step, is gone at once where that lowers the
/// residual.
class Extrapolation {
public:
  explicit Extrapolation(SNES snes)
      : snes_(snes), from_(snes->work[0]), x_(snes->work[1]), f_(snes->work[2]), before_(snes->norm) {}
  void step_from(Vec x) { check(VecCopy(x, from_)); }
  /// After a step to x, with the residual f and its norm. Returns the norm at x in the end. Collective.
  PetscReal go_on(Model& model, Vec x, Vec f, PetscReal norm);

private:
  SNES snes_;
  Vec from_, x_, f_;
  PetscReal before_, rate_ = 0; // norm before the step, and by what the one before changed it
};

PetscReal Extrapolation::go_on(Model& model, Vec x, Vec f, PetscReal norm) {
  constexpr PetscReal slow = 0.6, alike = 0.125; // of 1 - rho
  constexpr PetscReal longest = 0.01;            // of phi: the nearest solution is not passed over
  const PetscReal rate = norm / std::exchange(before_, norm), last = std::exchange(rate_, rate);
  if (!(rate > slow && rate < 1 && std::abs(rate - last) < alike * (1 - rate))) return norm;
  rate_ = 0;
  PetscReal step = 0;
  check(VecCopy(x, x_));
  check(VecCopy(f, f_));
  check(VecAYPX(from_, -1, x));
  check(VecNorm(from_, NORM_INFINITY, &step));
  check(VecAXPY(x, std::min(rate / (1 - rate), longest / step), from_));
  clip(snes_, x);
  check(SNESComputeFunction(snes_, x, f));
  if (!snes_->domainerror) {
    const PetscReal reached = model.start(x, f);
    if (reached < norm) return before_ = reached;
  }
  snes_->domainerror = PETSC_FALSE;
  check(VecCopy(x_, x));
  check(VecCopy(f_, f));
  return model.start(x, f);
}

void solve(SNES snes) {
  Model& model = *static_cast<Model*>(snes->data);
  const Vec x = snes->vec_sol, f = snes->vec_func;
  snes->reason = SNES_CONVERGED_ITERATING;
  snes->iter = 0;
  clip(snes, x);
  check(SNESComputeFunction(snes, x, f));
  const PetscReal norm = model.start(x, f), whole = model.whole();
  judge(snes, norm, whole);
  PetscReal forcing = 0;
  Extrapolation rest(snes);
  while (!snes->reason && snes->iter < snes->max_its) {
    if (snes->ops->update) check(snes->ops->update(snes, snes->iter));
    check(SNESComputeJacobian(snes, x, snes->jacobian, snes->jacobian_pre));
    const PetscReal target = std::max({snes->abstol / 2, snes->ttol / 10, forcing * snes->norm});
    if (!model.minimise(snes, target) && ++snes->numLinearSolveFailures >= snes->maxLinearSolveFailures) {
      snes->reason = SNES_DIVERGED_LINEAR_SOLVE;
      return;
    }
    rest.step_from(x);
    check(VecCopy(model.solution(), x));
    check(SNESComputeFunction(snes, x, f));
    ++snes->iter;
    PetscReal reached = model.start(x, f);
    if (!snes->domainerror) reached = rest.go_on(model, x, f, reached);
    judge(snes, reached, whole);
    forcing = snes->norm > 10 * target ? 1e-3 : 0; // what is not quadratic asks for no exact minimum
  }
  if (!snes->reason) snes->reason = SNES_DIVERGED_MAX_IT;
}

PetscErrorCode set_up(SNES snes) {
  return guarded([&] {
    check(SNESSetUpMatrices(snes));
    check(SNESSetWorkVecs(snes, 3));
    static_cast<Model*>(snes->data)->set_up(snes);
  });
}

PetscErrorCode reset(SNES snes) {
  *static_cast<Model*>(snes->data) = Model{};
  return 0;
}

PetscErrorCode destroy(SNES snes) {
  for (Vec* bound : {&snes->xl, &snes->xu}) // which PETSc's own methods with bounds release
    if (const PetscErrorCode code = VecDestroy(bound)) return code;
  delete static_cast<Model*>(snes->data);
  snes->data = nullptr;
  return 0;
}

PetscErrorCode create(SNES snes) {
  snes->data = new Model;
  snes->ops->setup = set_up;
  snes->ops->solve = [](SNES solved) { return guarded([&] { solve(solved); }); };
  snes->ops->reset = reset;
  snes->ops->destroy = destroy;
  snes->usesksp = PETSC_TRUE;
  snes->usesnpc = PETSC_FALSE;
  return 0;
}

} // namespace

void register_bounded_newton() { check(SNESRegister(vi_newton_qp, create)); }

} // namespace impact
