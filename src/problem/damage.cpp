#include "damage_batches.hpp"
#include "nodal_rate.hpp"
#include <algorithm>
#include <cmath>
#include <impact/mesh/agreed_error.hpp>
#include <impact/petsc/bounded_newton.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/field_solver.hpp>
#include <impact/petsc/log.hpp>

/// The bounded solve. Sub-steps: damage_substeps.cpp; what a step dissipated: damage_book.cpp.
namespace impact {

namespace {

// Laws whose unconstrained problem has no solution, or not the wanted one: those with a threshold would take
// virgin material below 0, as does a split whose E+ may be negative; a concave degradation may have no
// minimum at all.
bool needs_bounds(const PointLaw& law) {
  const MaterialParameters& m = law.parameters;
  return damages(law) && (regularisation(m).linear > 0 || !is_convex(m) || compressed_share(m) < 0);
}

// [node] 1 where phi is prescribed or no damaging cell touches it on any rank.
std::vector<char> held_nodes(const Discretisation& d, const BoundaryData& boundary) {
  std::vector<double> touched = d.scalar.make_local();
  for (const CellGroup& group : d.groups)
    if (damages(d.law(group)))
      for (int node : group.node) touched[at(node)] = 1;
  add_up(d.scalar, touched);
  std::vector<char> held;
  for (std::size_t i = 0; i < touched.size(); ++i)
    held.push_back(boundary.damage_condition()[i] >= 0 || touched[i] == 0);
  return held;
}

// What g_1' multiplies in the source: E+, and what else of E-, H_0 the law degrades by the same function; the
// others are not degraded at all.
Batch driving_energy(const MaterialParameters& m, const Drive& drive) {
  Batch sum = drive.plus;
  if (const double share = compressed_share(m); share != 0) sum += share * drive.minus;
  if (m.gp == PlasticDegradation::ge) sum += drive.plastic;
  return sum;
}

} // namespace

DamageProblem::DamageProblem(const Discretisation& discretisation, StateTable& state,
                             const BoundaryData& boundary, const DamageScenario& settings)
    : d_(discretisation), boundary_(boundary), settings_(settings),
      field_(d_, held_nodes(d_, boundary_), has_linear_damage(settings_, d_.mesh)), phi_(state.row("phi")),
      drive_(state.row("drive")), flow_(state.row("history")), x_(d_.node_values(1)), r_(d_.node_values(1)),
      substep_start_(d_.scalar.make_local()), substep_end_(substep_start_), lower_(d_.scalar.make_global()),
      upper_(d_.scalar.make_global()) {
  double toughness = 0;
  const bool vi = settings_.bounds == DamageBounds::vi;
  for (const PointLaw& law : d_.laws)
    if (damages(law)) {
      toughness = std::max(toughness, law.parameters.Gc);
      bounded_at_once_ = bounded_at_once_ || (vi && needs_bounds(law));
      width_ = std::max(width_, law.parameters.gamma);
    }
  reference_ = 1e-12 * toughness / width_ * d_.small_cell();
  const std::size_t points = d_.point_values(1);
  dissipated_.resize(points);
  if (d_.has_fatigue()) worn_ = &state.row("fatigue");
  if (d_.has_toughness()) toughness_ = &state.row("toughness");
  if (settings_.bounds == DamageBounds::history)
    history_ = &state.add({"damage_history", Support::cell_point, 1}, points);
  microforce_ = &state.add({"force_damage", Support::vertex, 1}, d_.node_values(1));
  prescribes_ = !all_ranks_agree(d_.mesh.comm(), std::all_of(boundary_.damage_condition().begin(),
                                                             boundary_.damage_condition().end(),
                                                             [](int condition) { return condition < 0; }));
  field_.build_matrix();
  make_solver();
  make_substeps();
}

void DamageProblem::make_solver() {
  check(SNESCreate(d_.mesh.comm(), snes_.out()));
  check(SNESSetOptionsPrefix(snes_, "damage_"));
  check(SNESSetFunction(snes_, field_.residual(), Callback<&DamageProblem::residual>::call, this));
  check(SNESSetJacobian(snes_, field_.matrix(), field_.matrix(), Callback<&DamageProblem::tangent>::call,
                        this));
  prepare(snes_);
  check(SNESSetFromOptions(snes_));
  check(SNESGetTolerances(snes_, &residual_tol_, nullptr, nullptr, nullptr, nullptr));
  const bool vi = settings_.bounds == DamageBounds::vi;
  if (vi) suit_linear_solver(snes_);
  settle_solver(Get(SNESGetKSP)(snes_));
  if (!vi) return check(SNESSetType(snes_, SNESNEWTONLS)); // -damage_snes_type names the bounded method
  check(SNESVISetVariableBounds(snes_, lower_, upper_));
  if (!has_type(snes_.get(), vi_newton_qp) && has_type(Get(KSPGetPC)(Get(SNESGetKSP)(snes_)), PCGAMG))
    throw UserError(
        ExitCode::usage,
        "-damage_pc_type gamg does not work with -damage_snes_type vinewtonrsls (the reduced system "
        "changes its size); leave -damage_snes_type out");
}

void DamageProblem::prepare(SNES snes) {
  register_bounded_newton();
  // The first residual has the thresholds of all that is sound, beside which the front of a crack is little.
  const double rtol = d_.lumped_mass ? 1e-8 : 1e-9;
  field_.prepare(snes, settings_.bounds == DamageBounds::vi ? vi_newton_qp : SNESNEWTONLS, reference_, rtol,
                 100, width_);
  if (bounded_at_once_) take_full_steps(snes);
}

// The semismooth method's matrix is not symmetric: incomplete Cholesky factors of it do not come to an end.
void DamageProblem::suit_linear_solver(SNES snes) {
  if (!has_type(snes, SNESVINEWTONSSLS)) return;
  const KSP ksp = Get(SNESGetKSP)(snes);
  const PC pc = Get(KSPGetPC)(ksp);
  check(KSPSetType(ksp, KSPGMRES));
  check(PCSetType(pc, PCJACOBI));
  check(KSPSetFromOptions(ksp));
  if (has_type(pc, PCICC, PCCHOLESKY))
    throw UserError(ExitCode::usage, "-damage_pc_type: icc and cholesky want a symmetric matrix, which "
                                     "-damage_snes_type vinewtonssls has not; use jacobi, ilu or lu");
}

// A matrix that is larger than the derivative makes steps that lower the energy but not always the residual,
// which may grow by orders of magnitude where a crack forms.
void DamageProblem::take_full_steps(SNES snes) {
  const SNESLineSearch search = Get(SNESGetLineSearch)(snes);
  check(SNESLineSearchSetType(search, SNESLINESEARCHBASIC));
  check(SNESSetDivergenceTolerance(snes, -1));
}

void DamageProblem::forget_factors() {
  for (SNES snes : solvers()) impact::forget_factors(snes);
}

std::vector<SNES> DamageProblem::solvers() const {
  std::vector<SNES> all(1, snes_.get());
  if (substeps_ && !rate_) check(TSGetSNES(substeps_, &all.emplace_back()));
  return all;
}

// f of the cells at t_n.
Batch DamageProblem::toughness(const CellBatch& batch) const {
  return batch.toughness(worn_ ? &worn_->committed : nullptr, toughness_ ? &toughness_->committed : nullptr);
}

bool DamageProblem::assemble_forces(const Equation& equation, Vec x, Vec f) {
  const Timed timed(Event::damage_residual);
  std::fill(r_.begin(), r_.end(), 0.0);
  const bool sound = visit_batches(equation, x, [&](const CellBatch& batch, const DamageInput& in) {
    auto r = batch.zero(1);
    const int bad = batch.kernels.damage_residual(batch.law, in, r.data());
    if (batch.changes_toughness()) {
      const Batch left = toughness(batch);
      for (Batch& force : r.all()) force *= left;
    }
    batch.scatter(r, r_);
    return bad;
  });
  field_.assemble(r_, f);
  return sound;
}

void DamageProblem::residual(SNES, Vec x, Vec f) {
  const bool sound = assemble_forces(equation_, x, f);
  field_.zero_held(f);
  if (!sound)
    for (SNES snes : solvers()) check(SNESSetFunctionDomainError(snes));
}

void DamageProblem::tangent(SNES, Vec x, Mat, Mat) {
  const Timed timed(Event::damage_tangent);
  CellMatrix K;
  field_.zero_matrix();
  visit_batches(equation_, x, [&](const CellBatch& batch, const DamageInput& in) {
    auto r = batch.zero(1);
    const int bad = batch.kernels.damage_tangent(batch.law, in, r.data(), K.zeroed(batch.nodes()));
    if (batch.changes_toughness()) K.scale(toughness(batch));
    field_.add(batch, K);
    return bad;
  });
  field_.finish_matrix();
  field_.close_matrix(solvers());
}

void DamageProblem::raise_history() {
  if (!history_) return;
  const Timed timed(Event::damage_points);
  for_each_batch(d_, all_laws, [&](const CellBatch& batch) {
    const auto now = batch.load<drive_size>(drive_.trial);
    auto H = batch.load<1>(history_->committed);
    for (int q = 0; q < H.size; ++q)
      H.value[q] = max(H.value[q], driving_energy(batch.law.parameters, drive_at(now.data(), q)));
    batch.store(H, history_->trial);
  });
}

// phi_n <= phi <= 1; held values are their own bounds.
void DamageProblem::set_bounds(const std::vector<double>& phi_n, const std::vector<double>& phi) {
  std::vector<double> low = phi_n, high(low.size(), 1.0);
  for (std::size_t i = 0; i < low.size(); ++i)
    if (field_.held()[i]) low[i] = high[i] = phi[i];
  d_.scalar.to_global(low, lower_);
  d_.scalar.to_global(high, upper_);
}

void DamageProblem::clip() {
  check(VecPointwiseMax(field_.solution(), field_.solution(), lower_));
  check(VecPointwiseMin(field_.solution(), field_.solution(), upper_));
}

void DamageProblem::rest() {
  work_ = 0;
  std::fill(dissipated_.begin(), dissipated_.end(), 0.0);
}

ScalarOutcome DamageProblem::solve(const DamageStep& step, std::vector<double>& phi) {
  step_ = step;
  equation_ = {settings_.form, settings_.theta, step.dt, step.phi_n};
  rest();
  raise_history();
  agree_on_errors(d_.mesh.comm(), [&] { boundary_.set_damage(step.t, phi); });
  field_.fill_middles(phi);
  bool heals = false; // where a prescribed value lies below phi_n
  for (std::size_t i = 0; i < phi.size(); ++i)
    heals = heals || (field_.held()[i] && phi[i] < (*step.phi_n)[i] - 1e-12);
  if (!all_ranks_agree(d_.mesh.comm(), !heals))
    throw UserError(ExitCode::data,
                    "a prescribed phi is below the damage that the node already has; damage cannot heal");
  d_.scalar.to_global(phi, field_.solution());
  set_bounds(*step.phi_n, phi);
  for (SNES snes : solvers())
    check(SNESSetTolerances(snes, residual_tol_, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  if (substeps_) return solve_substeps(step, phi);

  const ScalarOutcome outcome = solve_field(snes_, field_.solution(), mailbox_);
  if (outcome.reason < 0) return outcome;
  if (settings_.bounds == DamageBounds::vi || settings_.bounds == DamageBounds::clip) clip();
  field_.to_local(field_.solution(), phi);
  book_rate(*step.phi_n, phi, step.dt);
  book_energy(*step.phi_n, phi);
  return outcome;
}

} // namespace impact
