#include <algorithm>
#include <cmath>
#include <impact/mesh/agreed_error.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/field_solver.hpp>
#include <impact/petsc/log.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/heat.hpp>

namespace impact {

HeatProblem::HeatProblem(const Discretisation& discretisation, StateTable& state,
                         const BoundaryData& boundary, const HeatScenario& settings, bool moves,
                         const ContactSet* contacts)
    : d_(discretisation), boundary_(boundary), settings_(settings), loads_(d_, boundary_),
      field_(d_, held_nodes(boundary_), settings.order == 1), theta_(state.row("theta")),
      history_(state.row("history")), drive_(state.find("drive")), x_(d_.node_values(1)),
      r_(d_.node_values(1)), constant_(d_.node_values(1)), flows_(moves && d_.has_plasticity()) {
  const std::size_t points = d_.point_values(1);
  points_.resize(points * heat_point_size);
  const int stresses = stress_size(d_.frame);
  if (moves && settings_.form == HeatForm::energy)
    stress_ = &state.add({"stress", Support::cell_point, stresses}, points * at(stresses));
  if (moves && d_.any_law([](const PointLaw& law) { return law.parameters.alpha_t != 0; }))
    warming_ = &state.add({"warming", Support::cell_point, warming_size}, points * warming_size);
  if (d_.has_fatigue()) worn_ = &state.row("fatigue");
  double capacity = 0, temperature = 0;
  for (const MaterialAssignment& m : d_.materials) {
    capacity = std::max(capacity, m.law.parameters.c_v);
    temperature = std::max(temperature, m.law.parameters.theta0);
  }
  if (contacts)
    for (const ContactInterface& contact : *contacts)
      if (contact.passes_heat()) contacts_.emplace_back(d_.mesh, contact);
  supplied_ = {std::vector<double>(boundary_.conditions().size(), 0.0),
               std::vector<ContactHeat::Heat>(contacts_.size())};
  if (settings.order == 1 && d_.mesh.order() == 2 && !contacts_.empty())
    throw UserError(ExitCode::usage, "-heat_order 1: not where heat passes a contact; allowed: 2, or that of "
                                     "the cells; remove it");
  if (settings_.substep > 0 && !contacts_.empty())
    throw UserError(ExitCode::usage, "-heat_ts_dt: no sub-steps where heat passes a contact; remove it, or "
                                     "choose a smaller -ts_dt");
  check(SNESCreate(d_.mesh.comm(), snes_.out()));
  check(SNESSetOptionsPrefix(snes_, "heat_"));
  check(SNESSetFunction(snes_, field_.residual(), Callback<&HeatProblem::residual>::call, this));
  make_matrix();
  holds_ = !all_ranks_agree(d_.mesh.comm(), field_.owned_held().empty());
  const double rounding = 1e-15 * capacity * temperature * d_.small_cell();
  field_.prepare(snes_, SNESNEWTONLS, rounding, 1e-10, 50);
  check(SNESSetFromOptions(snes_));
  settle_solver(Get(SNESGetKSP)(snes_));
  check(SNESGetTolerances(snes_, &residual_tol_, nullptr, nullptr, nullptr, nullptr));
}

std::vector<char> HeatProblem::held_nodes(const BoundaryData& boundary) {
  std::vector<char> held;
  for (int condition : boundary.temperature_condition()) held.push_back(condition >= 0);
  return held;
}

void HeatProblem::make_matrix() {
  NodePairs extra;
  for (const ContactHeat& contact : contacts_)
    extra.insert(extra.end(), contact.couplings().begin(), contact.couplings().end());
  field_.build_matrix(extra);
  check(
      SNESSetJacobian(snes_, field_.matrix(), field_.matrix(), Callback<&HeatProblem::tangent>::call, this));
}

void HeatProblem::begin_contacts() {
  if (contacts_.empty()) return;
  bool changed = false;
  for (ContactHeat& contact : contacts_) changed = contact.renew() || changed;
  if (changed) {
    forget_factors();
    make_matrix();
  }
  d_.scalar.to_global(theta_.committed, field_.residual());
  for (ContactHeat& contact : contacts_) {
    double rigid = 0;
    if (const auto& theta = contact.contact().settings().rigid_temperature)
      rigid = settings_.theta * theta(t_) + (1 - settings_.theta) * theta(t_n_);
    if (rigid < 0)
      throw UserError(ExitCode::data, "-contact_" + contact.contact().id() +
                                          "_temperature: is negative at t=" + std::to_string(t_) +
                                          "; temperatures are absolute and positive");
    contact.begin(step_.displacement, field_.residual(), t_ - t_n_, settings_.theta, rigid);
  }
}

HeatRows HeatProblem::rows() {
  HeatRows rows;
  if (stress_) {
    rows.stress = &stress_->trial;
    step_stress_.resize(rows.stress->size());
    rows.step_stress = &step_stress_;
  }
  return rows;
}

std::vector<std::string> HeatProblem::contacts() const {
  std::vector<std::string> ids;
  for (const ContactHeat& contact : contacts_) ids.push_back(contact.contact().id());
  return ids;
}

void HeatProblem::forget_factors() { impact::forget_factors(snes_); }

void HeatProblem::begin(double t_n, double t) {
  t_n_ = t_n;
  t_ = t;
  agree_on_errors(d_.mesh.comm(), [&] { loads_.evaluate(t_n, t, settings_.theta); });
}

namespace {

// What a row is at both ends of a part of the step.
template <class Values> void cut_to(double begin, double end, Values& now, Values& before) {
  for (int i = 0; i < now.size; ++i) {
    const Batch change = now.value[i] - before.value[i], start = before.value[i];
    now.value[i] = start + end * change;
    before.value[i] = start + begin * change;
  }
}

} // namespace

// body(batch, input of the kernels at theta) answers with the lanes that lost their meaning; false where any
// did.
template <class Body>
bool HeatProblem::visit_batches(const std::vector<double>& theta, Reads reads, Body&& body) {
  const bool energy = settings_.form == HeatForm::energy, all = reads == Reads::window,
             both_ends = all || !window_.whole();
  bool sound = true;
  for_each_batch(d_, all_laws, [&](const CellBatch& batch) {
    const PointLaw& law = batch.law;
    const auto X = batch.vectors(d_.mesh.coordinates());
    const auto now = batch.scalars(theta), before = batch.scalars(theta_at_start());
    NodalValues u(X.size), u_n(X.size), phi(now.size), phi_n(now.size);
    BatchArray<1> patch(1), patch_n(1), patch_work(1);
    auto A = batch.histories(), A_n = batch.histories();
    auto E = batch.points<drive_size>(), E_n = batch.points<drive_size>();
    auto P = batch.stresses(), P_n = batch.stresses();
    auto dissipation = batch.points<1>(), worn = batch.points<1>(), worn_n = batch.points<1>();
    HeatInput in;
    // What a field is at the ends of the window, for the kernels.
    const auto put = [&](const std::vector<double>* end, auto& values, const Batch*& in_end,
                         const std::vector<double>* start, auto& values_n, const Batch*& in_start,
                         bool cuts = true) {
      in_end = batch.read(end, values);
      in_start = batch.read(both_ends ? start : nullptr, values_n);
      if (cuts && end && !window_.whole()) cut_to(window_.begin, window_.end, values, values_n);
    };
    const auto put_row = [&](const StateRow& row, auto& values, const Batch*& in_end, auto& values_n,
                             const Batch*& in_start, bool cuts = true) {
      put(&row.trial, values, in_end, &row.committed, values_n, in_start, cuts);
    };
    in.X = X.data(), in.theta = now.data(), in.theta_n = before.data();
    if (all || law.parameters.conductivity != 0 || law.principal())
      put(step_.u, u, in.u, step_.u_n, u_n, in.u_n);
    if (in.u) batch.forget_eroded(u);
    if (in.u_n) batch.forget_eroded(u_n);
    put(step_.phi, phi, in.phi, step_.phi_n, phi_n, in.phi_n);
    // A ductile degradation asks for alpha, a split by principal stretches for what is elastic of them,
    // sheets for their stretch across.
    const bool looked_at = is_ductile(law.parameters) || (law.principal() && law.flows()) ||
                           d_.frame == Frame::plane_stress,
               exchanges = all && !energy && step_.u && step_.phi && law.exchanges();
    if ((all && energy && flows_) || exchanges || (step_.u && looked_at))
      put_row(history_, A, in.history, A_n, in.history_n);
    if (all) {
      in.patch = batch.read_shared(patches_.J_minus_1, patch);
      in.patch_n = batch.read_shared(patches_n_.J_minus_1, patch_n);
      in.patch_work = batch.read_shared(patch_work_, patch_work);
      if (worn_ && law.fatigues()) put_row(*worn_, worn, in.fatigue, worn_n, in.fatigue_n);
      // Linear in time like F: the works of the sub-steps add up to that of the step.
      if (stress_) put(&step_stress_, P, in.stress, &stress_->committed, P_n, in.stress_n);
    }
    // The exchange of the entropy form takes the energies of the end, like damage.
    if ((all && energy && law.softens()) || exchanges) put_row(*drive_, E, in.drive, E_n, in.drive_n, energy);
    if (all && !energy && step_.dissipation) {
      in.dissipation = batch.read(step_.dissipation, dissipation);
      for (Batch& lost : dissipation.all()) lost *= window_.end - window_.begin;
    }
    in.dt = t_ - t_n_, in.theta_h = settings_.theta, in.form = settings_.form, in.lumped = d_.lumped_capacity;
    sound = batch.broken(body(batch, in)) == 0 && sound;
  });
  return sound;
}

// At a part of the step, where bodies move.
void HeatProblem::share_volume(double part, PatchState& patches) const {
  if (!step_.u || d_.patches.empty()) return;
  std::vector<double> u = *step_.u;
  for (std::size_t i = 0; part < 1 && i < u.size(); ++i)
    u[i] = (*step_.u_n)[i] + part * (u[i] - (*step_.u_n)[i]);
  share_volumes(d_, {&u}, patches);
}

// The work of the pressures of patches in the window, per volume.
void HeatProblem::share_work() {
  patch_work_.clear();
  if (stress_ == nullptr || d_.patches.empty()) return;
  PatchSum work(d_);
  visit_batches(x_, Reads::window, [&](const CellBatch& batch, const HeatInput& in) {
    if (batch.patched()) work.add(batch, batch.kernels.pressure_work(in));
    return 0;
  });
  work.put_mean(patches_, patch_work_);
}

bool HeatProblem::make_constant_part() {
  const Timed timed(Event::heat_loads);
  std::fill(constant_.begin(), constant_.end(), 0.0);
  share_volume(window_.end, patches_);
  share_volume(window_.begin, patches_n_);
  share_work();
  const bool sound = visit_batches(x_, Reads::window, [&](const CellBatch& batch, const HeatInput& in) {
    auto points = batch.points<heat_point_size>();
    auto r = batch.zero(1);
    const int bad = batch.kernels.heat_step(batch.law, in, points.data(), r.data());
    batch.store(points, points_);
    batch.scatter(r, constant_);
    return bad;
  });
  load_.assign(constant_.size(), 0.0);
  load_supplied_.assign(supplied_.by_condition.size(), 0.0);
  loads_.add_start(settings_.theta, t_ - t_n_, theta_at_start(), load_, load_supplied_);
  for (std::size_t i = 0; i < load_.size(); ++i) constant_[i] -= load_[i];
  return all_ranks_agree(d_.mesh.comm(), sound);
}

bool HeatProblem::assemble_residual(const std::vector<double>& theta, Vec solution, Vec f) {
  const Timed timed(Event::heat_residual);
  for (std::size_t i = 0; i < r_.size(); ++i) r_[i] = -constant_[i];
  std::vector<double> counted(load_supplied_.size());
  loads_.add_end(settings_.theta * (t_ - t_n_), theta, r_, counted);
  for (double& value : r_) value = -value;
  const bool sound = visit_batches(theta, Reads::end, [&](const CellBatch& batch, const HeatInput& in) {
    auto points = batch.load<heat_point_size>(points_);
    auto part = batch.zero(1);
    const int bad = batch.kernels.heat_residual(batch.law, in, points.data(), part.data());
    if (warming_) batch.store(points, points_);
    batch.scatter(part, r_);
    return bad;
  });
  const bool all_sound = all_ranks_agree(d_.mesh.comm(), sound);
  field_.assemble(r_, f);
  for (const ContactHeat& contact : contacts_) contact.add_residual(solution, f);
  return all_sound;
}

void HeatProblem::residual(SNES, Vec x, Vec f) {
  field_.to_local(x, x_);
  const bool sound = assemble_residual(x_, x, f);
  field_.zero_held(f);
  if (!sound) check(SNESSetFunctionDomainError(snes_));
}

void HeatProblem::tangent(SNES, Vec x, Mat, Mat) {
  const Timed timed(Event::heat_tangent);
  field_.to_local(x, x_);
  CellMatrix K;
  field_.zero_matrix();
  visit_batches(x_, Reads::end, [&](const CellBatch& batch, const HeatInput& in) {
    auto points = batch.load<heat_point_size>(points_);
    auto r = batch.zero(1);
    const int bad =
        batch.kernels.heat_tangent(batch.law, in, points.data(), r.data(), K.zeroed(batch.nodes()));
    field_.add(batch, K);
    return bad;
  });
  field_.finish_matrix();
  Mat matrix = field_.matrix();
  if (loads_.on_surfaces() || !contacts_.empty()) {
    if (!contacts_.empty() && !held_nodes_) {
      held_nodes_ = d_.scalar.make_global();
      d_.scalar.to_global(std::vector<double>(field_.held().begin(), field_.held().end()), held_nodes_);
    }
    for (const ContactHeat& contact : contacts_) contact.add_tangent(held_nodes_, matrix);
    loads_.add_tangent(settings_.theta * (t_ - t_n_), field_.held(), field_.middles(), matrix);
    check(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
    check(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
  }
  const SNES solver = snes_;
  field_.close_matrix({&solver, 1}, x);
}

// What flows in where the temperature is prescribed is the residual that is left there.
void HeatProblem::book() {
  const Vec solution = field_.solution(), residual = field_.residual();
  field_.to_local(solution, x_);
  // Loads of this rank's cells and facets, and what flows in at held nodes: each node's heat at its
  // temperature.
  std::vector<double> heat = load_;
  supplied_.by_condition = load_supplied_;
  loads_.add_end(settings_.theta * (t_ - t_n_), x_, heat, supplied_.by_condition);
  field_.fold_middles(heat);
  if (holds_) {
    assemble_residual(x_, solution, residual);
    d_.scalar.to_local(residual, r_);
    for (int node : field_.owned_held()) {
      heat[at(node)] += r_[at(node)];
      if (const int condition = boundary_.temperature_condition()[at(node)]; condition >= 0)
        supplied_.by_condition[at(condition)] += r_[at(node)];
    }
  }
  if (!contacts_.empty()) {
    // What rigid bodies conducted, at the owners of the nodes.
    check(VecSet(residual, 0));
    for (std::size_t i = 0; i < contacts_.size(); ++i)
      supplied_.by_contact[i] = contacts_[i].book(solution, residual);
    d_.scalar.to_local(residual, r_);
    for (std::size_t i = 0; i < heat.size(); ++i)
      if (d_.mesh.owned(static_cast<int>(i))) heat[i] += r_[i];
  }
  double entropy = 0;
  for (std::size_t i = 0; i < heat.size(); ++i) entropy += heat[i] / x_[i];
  supplied_.entropy = sum_over_ranks(d_.mesh.comm(), entropy);
  sum_over_ranks(d_.mesh.comm(), supplied_.by_condition);
}

const std::vector<double>& HeatProblem::theta_at_start() const {
  return window_.begin == 0 ? theta_.committed : theta_before_;
}

ScalarOutcome HeatProblem::solve(const HeatStep& step, std::vector<double>& theta) {
  step_ = step;
  // A step that is a whole number of sub-steps but for its last digits is not divided once more.
  const double count = settings_.substep > 0 ? std::ceil((t_ - t_n_) / settings_.substep * (1 - 1e-9)) : 1;
  return count > 1 ? solve_substeps(static_cast<int>(count), theta) : solve_window(theta);
}

ScalarOutcome HeatProblem::solve_substeps(int count, std::vector<double>& theta) {
  const double t_n = t_n_, t = t_;
  Supply supplied;
  supplied.by_condition.resize(supplied_.by_condition.size());
  ScalarOutcome sum;
  theta = theta_.committed;
  for (int k = 0; k < count; ++k) {
    window_ = {double(k) / count, k + 1 == count ? 1 : double(k + 1) / count};
    begin(t_n + window_.begin * (t - t_n), k + 1 == count ? t : t_n + window_.end * (t - t_n));
    theta_before_ = theta;
    const ScalarOutcome part = solve_window(theta);
    sum = {part.reason, sum.newton + part.newton, sum.linear + part.linear, part.cause};
    if (part.reason < 0) break;
    for (std::size_t c = 0; c < supplied.by_condition.size(); ++c)
      supplied.by_condition[c] += supplied_.by_condition[c];
    supplied.entropy += supplied_.entropy;
  }
  window_ = {};
  begin(t_n, t);
  supplied_ = std::move(supplied);
  return sum;
}

// Where a node is colder than nothing the points of a cell may still be warm; where more heat leaves than
// there is, the solve ends before.
void HeatProblem::refuse_below_zero(ScalarOutcome& outcome) {
  struct {
    double theta = HUGE_VAL, before = 0;
    double x[3] = {0, 0, 0};
  } coldest;
  field_.to_local(field_.solution(), x_);
  for (int i = 0; i < d_.mesh.node_count(); ++i)
    if (d_.mesh.owned(i) && x_[at(i)] < coldest.theta) {
      coldest.theta = x_[at(i)];
      coldest.before = theta_at_start()[at(i)];
      std::copy_n(&d_.mesh.coordinates()[at(i * d_.dim())], d_.dim(), coldest.x);
    }
  coldest = of_least(d_.mesh.comm(), coldest.theta, coldest);
  const bool failed = outcome.reason < 0;
  if (coldest.theta > (failed ? coldest.before / 2 : 0)) return;
  if (!failed) outcome.reason = SNES_DIVERGED_FUNCTION_DOMAIN;
  outcome.cause = (failed ? SNESConvergedReasons[outcome.reason] + std::string(" at ") : "") +
                  text_of("%.6g K at x=", coldest.theta) + place_text(coldest.x, d_.dim(), "%.6g", ",");
}

ScalarOutcome HeatProblem::solve_window(std::vector<double>& theta) {
  agree_on_errors(d_.mesh.comm(), [&] { boundary_.set_temperature(t_, theta); });
  field_.fill_middles(theta);
  x_ = theta;
  if (!make_constant_part()) return {.reason = SNES_DIVERGED_FUNCTION_DOMAIN};
  begin_contacts();
  d_.scalar.to_global(theta, field_.solution());
  check(SNESSetTolerances(snes_, residual_tol_, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  ScalarOutcome outcome = solve_field(snes_, field_.solution(), mailbox_);
  refuse_below_zero(outcome);
  if (outcome.reason < 0) return outcome;
  if (warming_ && window_.end == 1) keep_warming();
  book();
  theta = x_;
  return outcome;
}

} // namespace impact
