#include "owned_dofs.hpp"
#include <algorithm>
#include <cmath>
#include <impact/kernel/measure.hpp>
#include <impact/mesh/agreed_error.hpp>
#include <impact/petsc/forget.hpp>
#include <impact/petsc/log.hpp>
#include <impact/problem/cell_loop.hpp>
#include <impact/problem/damage.hpp>
#include <limits>

namespace impact {

namespace {

bool damages(const PointLaw& law) { return law.parameters.damage != Damage::none; }

/// Laws whose unconstrained problem has no solution, or not the wanted one: AT1 would take virgin material
/// below 0, a concave degradation may have no minimum at all.
bool needs_bounds(const PointLaw& law) {
  return damages(law) && (law.parameters.damage == Damage::at1 || !is_convex(law.parameters));
}

/// What g_1' multiplies in the source: E+, and what else of E-, H_0 the law degrades by the same function;
/// the others are not degraded at all. `drive` strides by `stride`.
template <class T> T driving_energy(const MaterialParameters& m, const T* drive, std::size_t stride) {
  T sum = drive[0];
  if (m.split == Split::none) sum = sum + drive[stride];
  if (m.gp == PlasticDegradation::ge) sum = sum + drive[2 * stride];
  return sum;
}

/// That energy in place of its parts.
template <class Cell> void put_history(const PointValues<Cell, 1>& H, PointValues<Cell, drive_size>& drive) {
  for (std::size_t q = 0; q < at(Cell::points); ++q)
    for (std::size_t k = 0; k < drive_size; ++k)
      drive.value[q * drive_size + k] = k == 0 ? H.value[q] : Batch(0.0);
}

} // namespace

DamageProblem::DamageProblem(const Discretisation& discretisation, StateTable& state,
                             const BoundaryData& boundary, const DamageScenario& settings)
    : d_(discretisation), state_(state), boundary_(boundary), settings_(settings),
      X_(d_.mesh.coordinates().begin(), d_.mesh.coordinates().end()), x_(d_.node_values(1)),
      r_(d_.node_values(1)), free_(d_.node_values(1), 0.0),
      drive_offset_(point_offsets(d_.groups, drive_size)),
      flow_offset_(point_offsets(d_.groups, history_size(d_.frame))),
      history_offset_(point_offsets(d_.groups, 1)) {
  // A node is solved for when a damaging cell touches it on any rank.
  double toughness = 0, width = 1;
  const bool bounded_needed = settings_.bounds == DamageBounds::vi;
  for (const CellGroup& group : d_.groups)
    if (damages(d_.law(group)))
      for (int node : group.node) free_[at(node)] = 1;
  for (const MaterialAssignment& m : d_.materials)
    if (damages(m.law)) {
      toughness = std::max(toughness, m.law.parameters.Gc);
      bounded_at_once_ = bounded_at_once_ || (bounded_needed && needs_bounds(m.law));
      width = m.law.parameters.gamma;
    }
  solution_ = d_.scalar.make_global();
  d_.scalar.add_to_global(free_, solution_);
  d_.scalar.to_local(solution_, free_);
  for (std::size_t i = 0; i < free_.size(); ++i) {
    free_[i] = free_[i] > 0 && !boundary_.fixed_damage_mask()[i] ? 1.0 : 0.0;
    if (free_[i] == 0 && d_.mesh.owned(static_cast<int>(i))) owned_held_.push_back(static_cast<int>(i));
  }
  reference_ = 1e-12 * toughness / width * std::pow(d_.mesh.smallest_edge(), d_.dim());
  if (settings_.bounds == DamageBounds::history) {
    StateRow row{"damage_history", Support::cell_point, 1};
    state_.add(std::move(row), history_offset_.back());
  }
  assembly_.emplace(d_.scalar, d_.mesh, d_.groups);
  residual_ = d_.scalar.make_global();
  diagonal_ = d_.scalar.make_global();
  lower_ = d_.scalar.make_global();
  upper_ = d_.scalar.make_global();

  for (Handle<SNES>* snes : {&unconstrained_, &bounded_}) {
    const bool bounded = snes == &bounded_;
    if (bounded && settings_.bounds != DamageBounds::vi) continue;
    check(SNESCreate(d_.mesh.comm(), snes->out()));
    check(SNESSetOptionsPrefix(*snes, "damage_"));
    check(SNESSetFunction(
        *snes, residual_,
        [](SNES, Vec x, Vec f, void* self) {
          auto& problem = *static_cast<DamageProblem*>(self);
          return problem.mailbox_.guarded([&] { problem.residual(x, f); });
        },
        this));
    check(SNESSetJacobian(
        *snes, matrix(), matrix(),
        [](SNES, Vec x, Mat, Mat, void* self) {
          auto& problem = *static_cast<DamageProblem*>(self);
          return problem.mailbox_.guarded([&] { problem.tangent(x); });
        },
        this));
    check(SNESSetType(*snes, bounded ? SNESVINEWTONRSLS : SNESNEWTONLS));
    if (bounded && bounded_at_once_) take_full_steps(*snes);
    if (!bounded) check(SNESSetConvergenceHistory(*snes, nullptr, nullptr, PETSC_DECIDE, PETSC_TRUE));
    set_tolerances(*snes);
    check(SNESSetFromOptions(*snes));
    if (!bounded) check(SNESSetType(*snes, SNESNEWTONLS)); // -damage_snes_type names the bounded method
    if (!bounded) check(SNESGetTolerances(*snes, &residual_tol_, nullptr, nullptr, nullptr, nullptr));
    if (bounded) {
      PetscBool gamg = PETSC_FALSE;
      KSP ksp = nullptr;
      PC pc = nullptr;
      check(SNESGetKSP(*snes, &ksp));
      check(KSPGetPC(ksp, &pc));
      check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(pc), PCGAMG, &gamg));
      if (gamg)
        throw UserError(ExitCode::usage,
                        "-damage_pc_type gamg does not work with -damage_bounds vi (the reduced "
                        "system changes its size); use icc, jacobi or hypre, or -damage_bounds history");
    }
  }
  microforce_ = &state_.add({"force_damage", Support::vertex, 1}, d_.node_values(1));
  dissipated_.resize(history_offset_.back());
  const auto& held = boundary_.fixed_damage_mask();
  prescribes_ = !all_ranks_agree(d_.mesh.comm(), std::find(held.begin(), held.end(), 1) == held.end());
  substep_start_ = substep_end_ = d_.scalar.make_local();
  make_substeps();
}

void DamageProblem::set_tolerances(SNES snes) {
  check(SNESSetTolerances(snes, reference_, 1e-9, 0, 100, PETSC_DEFAULT));
  KSP ksp = nullptr;
  check(SNESGetKSP(snes, &ksp));
  set_scalar_solver_defaults(ksp, "damage_");
}

// A matrix that is larger than the derivative makes steps that lower the energy but not always the residual,
// which may grow by orders of magnitude where a crack forms.
void DamageProblem::take_full_steps(SNES snes) {
  SNESLineSearch search = nullptr;
  check(SNESGetLineSearch(snes, &search));
  check(SNESLineSearchSetType(search, SNESLINESEARCHBASIC));
  check(SNESSetDivergenceTolerance(snes, -1));
}

template <class Output> bool DamageProblem::evaluate(Vec x, bool with_tangent, Output&& output) {
  d_.scalar.to_local(x, x_);
  const StateRow& drive = state_.row("drive");
  const StateRow* history = state_.find("damage_history");
  const StateRow* fatigue = state_.find("fatigue");
  bool sound = true;
  for (std::size_t g = 0; g < d_.groups.size(); ++g) {
    const CellGroup& group = d_.groups[g];
    const PointLaw& law = d_.law(group);
    if (!damages(law)) continue;
    with_shape(group, d_.frame, [&]<class Cell, Frame frame>() {
      constexpr int dim = Cell::dim, n = Cell::nodes;
      for (int b = 0; b < group.batch_count; ++b) {
        const Gathered<Cell, dim> X(group, b, X_), u(group, b, *step_.u), u_n(group, b, *step_.u_n);
        const Gathered<Cell, 1> phi(group, b, x_), phi_n(group, b, *step_.phi_n), free(group, b, free_);
        PointValues<Cell, drive_size> now, before;
        now.load(drive.trial, drive_offset_[g], b);
        before.load(drive.committed, drive_offset_[g], b);
        if (history) {
          PointValues<Cell, 1> H;
          H.load(history->trial, history_offset_[g], b);
          put_history<Cell>(H, now);
          H.load(history->committed, history_offset_[g], b);
          put_history<Cell>(H, before);
        }
        PointValues<Cell, 1> worn;
        DamageInput in;
        if (fatigue && law.fatigues()) {
          worn.load(fatigue->committed, history_offset_[g], b);
          in.fatigue = worn.data();
        }
        in.X = X.data();
        in.u = u.data();
        in.u_n = u_n.data();
        in.phi = phi.data();
        in.phi_n = phi_n.data();
        in.drive = now.data();
        in.drive_n = before.data();
        in.dt = step_.dt;
        in.form = settings_.form;
        in.theta_d = settings_.theta;
        in.convex = true;
        PointValues<Cell, history_size(frame)> flowed;
        if (is_ductile(law.parameters)) {
          flowed.load(state_.row("history").committed, flow_offset_[g], b);
          in.history = flowed.data();
        }
        std::array<Batch, at(n)> r{};
        std::array<Batch, at(n * n)> K{};
        const int bad = with_tangent ? damage_tangent<Cell, frame>(law, in, r.data(), K.data())
                                     : damage_residual<Cell, frame>(law, in, r.data());
        sound = sound && (bad & ((1 << group.lanes_in_use(b)) - 1)) == 0;
        if (with_tangent)
          for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) K[at(i * n + j)] *= free.value[at(i)] * free.value[at(j)];
        output(static_cast<int>(g), b, r.data(), K.data());
      }
    });
  }
  return all_ranks_agree(d_.mesh.comm(), sound);
}

void DamageProblem::forget_factors() {
  for (SNES snes : solvers()) impact::forget_factors(snes);
}

std::vector<SNES> DamageProblem::solvers() const {
  std::vector<SNES> all;
  for (const Handle<SNES>* snes : {&unconstrained_, &bounded_})
    if (*snes) all.push_back(snes->get());
  if (substeps_) {
    SNES snes = nullptr;
    check(TSGetSNES(substeps_, &snes));
    all.push_back(snes);
  }
  return all;
}

bool DamageProblem::assemble_forces(Vec x, Vec f) {
  const Timed timed(Event::damage_residual);
  std::fill(r_.begin(), r_.end(), 0.0);
  const bool sound = evaluate(x, false, [&](int g, int b, const Batch* r, const Batch*) {
    const CellGroup& group = d_.groups[at(g)];
    visit(group.shape, [&]<class Cell>(Cell) { scatter_add<Cell, 1>(group, b, r, r_.data()); });
  });
  check(VecSet(f, 0));
  d_.scalar.add_to_global(r_, f);
  return sound;
}

void DamageProblem::residual(Vec x, Vec f) {
  const bool sound = assemble_forces(x, f);
  zero_owned(f, d_.mesh, 1, owned_held_);
  if (!sound)
    for (SNES snes : solvers()) check(SNESSetFunctionDomainError(snes));
}

void DamageProblem::tangent(Vec x) {
  const Timed timed(Event::damage_tangent);
  assembly_->zero();
  evaluate(x, true, [&](int g, int b, const Batch*, const Batch* K) { assembly_->add(g, b, K); });
  assembly_->finish();
  double sum = 0;
  check(MatGetDiagonal(matrix(), diagonal_));
  check(VecSum(diagonal_, &sum));
  // No residual can fall below what the last digit of phi makes of its rows.
  for (SNES snes : solvers()) allow_rounding(snes, diagonal_);
  assembly_->set_diagonal(owned_held_,
                          sum > 0 ? sum / static_cast<double>(d_.mesh.global_node_count()) : 1.0);
}

// Nodal forces of the weak form at phi, held nodes included: those of the energy, and with a finite dt those
// of the rate too.
void DamageProblem::microforces(const std::vector<double>& phi, double dt, std::vector<double>& force) {
  const DamageScenario settings = settings_;
  const double step_dt = step_.dt;
  settings_.form = DamageForm::multiplied;
  settings_.theta = 1;
  step_.dt = dt;
  const Handle<Vec> x = d_.scalar.make_global(), f = d_.scalar.make_global();
  d_.scalar.to_global(phi, x);
  assemble_forces(x, f);
  d_.scalar.to_local(f, force);
  settings_ = settings;
  step_.dt = step_dt;
}

double DamageProblem::held_work(const std::vector<double>& force, const std::vector<double>& from,
                                const std::vector<double>& to) const {
  double work = 0;
  for (std::size_t i = 0; i < force.size(); ++i)
    if (d_.mesh.owned(static_cast<int>(i))) work += force[i] * (to[i] - from[i]);
  MPI_Allreduce(MPI_IN_PLACE, &work, 1, MPI_DOUBLE, MPI_SUM, d_.mesh.comm());
  return work;
}

void DamageProblem::keep_held(std::vector<double>& force) const {
  for (std::size_t i = 0; i < force.size(); ++i)
    if (!boundary_.fixed_damage_mask()[i]) force[i] = 0;
}

// The rate's part of a step or sub-step.
void DamageProblem::book_rate(const std::vector<double>& from, const std::vector<double>& to, double dt) {
  const Timed timed(Event::damage_points);
  for (std::size_t g = 0; g < d_.groups.size(); ++g) {
    const CellGroup& group = d_.groups[g];
    const PointLaw& law = d_.law(group);
    if (!damages(law)) continue;
    visit(group.shape, [&]<class Cell>(Cell) {
      for (int b = 0; b < group.batch_count; ++b) {
        const Gathered<Cell, 1> now(group, b, to), before(group, b, from);
        PointValues<Cell, 1> points;
        points.load(dissipated_, history_offset_[g], b);
        damage_dissipation<Cell>(law, now.data(), before.data(), dt, points.data());
        points.store(dissipated_, history_offset_[g], b);
      }
    });
  }
  if (!prescribes_) return;
  std::vector<double> with, without;
  with = without = d_.scalar.make_local();
  const std::vector<double>* phi_n = step_.phi_n;
  step_.phi_n = &from;
  microforces(to, dt, with);
  microforces(to, std::numeric_limits<double>::infinity(), without);
  step_.phi_n = phi_n;
  for (std::size_t i = 0; i < with.size(); ++i) with[i] -= without[i];
  keep_held(with);
  work_ += held_work(with, from, to);
}

// The energy's part of the whole step: the mean of both ends.
void DamageProblem::book_energy(const std::vector<double>& from, const std::vector<double>& to) {
  std::fill(microforce_->trial.begin(), microforce_->trial.end(), 0.0);
  if (prescribes_) {
    microforces(to, std::numeric_limits<double>::infinity(), microforce_->trial);
    keep_held(microforce_->trial);
  }
  work_ += (held_work(microforce_->committed, from, to) + held_work(microforce_->trial, from, to)) / 2;
}

void DamageProblem::start(const std::vector<double>& u) {
  const std::vector<double>& phi = state_.row("phi").committed;
  step_ = {.dt = std::numeric_limits<double>::infinity(), .u = &u, .u_n = &u, .phi_n = &phi};
  raise_history();
  std::vector<double>& force = microforce_->trial;
  microforces(phi, step_.dt, force);
  // What would grow at once without a rate is let go within the first step; with one it dissipates.
  const bool at_once = std::none_of(d_.materials.begin(), d_.materials.end(), [](const auto& m) {
    return damages(m.law) && std::isfinite(m.law.parameters.c);
  });
  for (std::size_t i = 0; i < force.size(); ++i)
    if (!boundary_.fixed_damage_mask()[i]) force[i] = at_once && free_[i] > 0 ? std::min(force[i], 0.0) : 0;
}

void DamageProblem::raise_history() {
  if (!state_.find("damage_history")) return;
  const Timed timed(Event::damage_points);
  StateRow& history = state_.row("damage_history");
  const StateRow& drive = state_.row("drive");
  for (std::size_t g = 0; g < d_.groups.size(); ++g)
    for (std::size_t i = history_offset_[g]; i < history_offset_[g + 1]; ++i) {
      const double* at = &drive.trial[i / lanes * drive_size * lanes + i % lanes];
      history.trial[i] =
          std::max(history.committed[i], driving_energy(d_.law(d_.groups[g]).parameters, at, lanes));
    }
}

bool DamageProblem::within_bounds(Vec x) const {
  const double *value = nullptr, *low = nullptr, *high = nullptr;
  PetscInt n = 0;
  check(VecGetLocalSize(x, &n));
  check(VecGetArrayRead(x, &value));
  check(VecGetArrayRead(lower_, &low));
  check(VecGetArrayRead(upper_, &high));
  bool inside = true;
  for (PetscInt i = 0; i < n; ++i)
    inside = inside && value[i] >= low[i] - 1e-14 && value[i] <= high[i] + 1e-14;
  check(VecRestoreArrayRead(upper_, &high));
  check(VecRestoreArrayRead(lower_, &low));
  check(VecRestoreArrayRead(x, &value));
  return all_ranks_agree(d_.mesh.comm(), inside);
}

ScalarOutcome DamageProblem::solve(const DamageStep& step, std::vector<double>& phi) {
  step_ = step;
  work_ = 0;
  std::fill(dissipated_.begin(), dissipated_.end(), 0.0);
  raise_history();
  agree_on_errors(d_.mesh.comm(), [&] { boundary_.set_damage(step.t, phi); });
  d_.scalar.to_global(phi, solution_);
  // Held values are their own bounds; a prescribed value below phi_n would be healing.
  std::vector<double> low = *step.phi_n, high(low.size(), 1.0);
  bool heals = false;
  for (std::size_t i = 0; i < low.size(); ++i)
    if (free_[i] == 0) {
      heals = heals || phi[i] < low[i] - 1e-12;
      low[i] = high[i] = phi[i];
    }
  if (!all_ranks_agree(d_.mesh.comm(), !heals))
    throw UserError(ExitCode::data,
                    "a prescribed phi is below the damage that the node already has; damage cannot heal");
  d_.scalar.to_global(low, lower_);
  d_.scalar.to_global(high, upper_);

  for (SNES snes : solvers())
    check(SNESSetTolerances(snes, residual_tol_, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  if (substeps_) return solve_substeps(step, phi);
  // The norm that SNES saw before its first iteration.
  const auto first_residual = [](SNES snes) {
    PetscReal* history = nullptr;
    PetscInt count = 0;
    check(SNESGetConvergenceHistory(snes, &history, nullptr, &count));
    return count > 0 ? history[0] : 0.0;
  };
  ScalarOutcome outcome;
  const auto run = [&](SNES snes) {
    mailbox_.deliver(SNESSolve(snes, nullptr, solution_));
    PetscInt newton = 0, linear = 0;
    outcome.reason = reason_by_residual(snes);
    check(SNESGetIterationNumber(snes, &newton));
    check(SNESGetLinearSolveIterations(snes, &linear));
    outcome.newton += newton;
    outcome.linear += linear;
  };
  PetscReal start_norm = 0;
  if (bounded_at_once_) {
    check(VecPointwiseMax(solution_, solution_, lower_));
    check(VecPointwiseMin(solution_, solution_, upper_));
    residual(solution_, residual_);
    check(VecNorm(residual_, NORM_2, &start_norm));
  } else {
    run(unconstrained_);
    start_norm = first_residual(unconstrained_);
    if (outcome.reason < 0) return outcome;
  }
  const bool bounded = settings_.bounds == DamageBounds::vi || settings_.bounds == DamageBounds::clip;
  if (bounded_at_once_ || (bounded && !within_bounds(solution_))) {
    check(VecPointwiseMax(solution_, solution_, lower_));
    check(VecPointwiseMin(solution_, solution_, upper_));
    if (settings_.bounds == DamageBounds::vi) {
      check(SNESVISetVariableBounds(bounded_, lower_, upper_));
      // Its own first residual is small already: it is held to the accuracy of the unconstrained solve, and
      // not below what a round-off of phi makes in the stiffest row (a cell stretched by an open crack).
      PetscReal stiffest = 0;
      check(VecMax(diagonal_, nullptr, &stiffest));
      check(SNESSetTolerances(bounded_, std::max({reference_, 1e-9 * start_norm, 1e-12 * stiffest}),
                              PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
      run(bounded_);
      check(VecPointwiseMax(solution_, solution_, lower_));
      check(VecPointwiseMin(solution_, solution_, upper_));
    }
  }
  d_.scalar.to_local(solution_, phi);
  book_rate(*step.phi_n, phi, step.dt);
  book_energy(*step.phi_n, phi);
  return outcome;
}

} // namespace impact
