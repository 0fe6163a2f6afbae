#include "owned_dofs.hpp"
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <impact/mesh/agreed_error.hpp>
#include <impact/petsc/forget.hpp>
#include <impact/petsc/log.hpp>
#include <impact/problem/cell_loop.hpp>
#include <impact/problem/heat.hpp>
#include <map>

namespace impact {

HeatProblem::HeatProblem(const Discretisation& discretisation, StateTable& state,
                         const BoundaryData& boundary, const HeatScenario& settings, bool moves,
                         const ContactSet* contacts)
    : d_(discretisation), state_(state), boundary_(boundary), settings_(settings),
      X_(d_.mesh.coordinates().begin(), d_.mesh.coordinates().end()), x_(d_.node_values(1)),
      r_(d_.node_values(1)), constant_(d_.node_values(1)), free_(d_.node_values(1), 1.0),
      held_(d_.node_values(1), 0), history_offset_(point_offsets(d_.groups, history_size(d_.frame))),
      drive_offset_(point_offsets(d_.groups, drive_size)), dissipation_offset_(point_offsets(d_.groups, 1)),
      stress_offset_(point_offsets(d_.groups, gradient_size(d_.frame))),
      point_offset_(point_offsets(d_.groups, heat_point_size)), supplied_(boundary_.conditions().size(), 0.0),
      moves_(moves), flows_(moves && d_.has_plasticity()) {
  for (std::size_t i = 0; i < free_.size(); ++i)
    if (boundary_.temperature_condition()[i] >= 0) {
      free_[i] = 0;
      held_[i] = 1;
      if (d_.mesh.owned(static_cast<int>(i))) owned_held_.push_back(static_cast<int>(i));
    }
  points_.resize(point_offset_.back());
  if (moves_ && settings_.form == HeatForm::energy)
    state_.add({"stress", Support::cell_point, gradient_size(d_.frame)}, stress_offset_.back());
  find_regions();
  for (const LoadedFacets& load : boundary_.heat_fluxes()) {
    Surface& surface = surfaces_.emplace_back(Surface{&load, {}});
    for (SurfaceHeat& heat : surface.heat) {
      heat.inflow.resize(at(load.facets.count()) * points_per_facet);
      heat.coefficient.resize(heat.inflow.size());
    }
  }
  double capacity = 0, temperature = 0;
  for (const MaterialAssignment& m : d_.materials) {
    capacity = std::max(capacity, m.law.parameters.c_v);
    temperature = std::max(temperature, m.law.parameters.theta0);
  }
  if (contacts && moves_)
    for (const ContactInterface& contact : *contacts)
      if (contact.passes_heat()) contacts_.emplace_back(d_.mesh, contact);
  contact_heat_.resize(contacts_.size());
  solution_ = d_.scalar.make_global();
  residual_ = d_.scalar.make_global();
  diagonal_ = d_.scalar.make_global();

  check(SNESCreate(d_.mesh.comm(), snes_.out()));
  check(SNESSetOptionsPrefix(snes_, "heat_"));
  check(SNESSetFunction(
      snes_, residual_,
      [](SNES, Vec x, Vec f, void* self) {
        auto& problem = *static_cast<HeatProblem*>(self);
        return problem.mailbox_.guarded([&] { problem.residual(x, f); });
      },
      this));
  build_matrix();
  check(SNESSetType(snes_, SNESNEWTONLS));
  const double rounding = 1e-15 * capacity * temperature * std::pow(d_.mesh.smallest_edge(), d_.dim());
  check(SNESSetTolerances(snes_, rounding, 1e-10, 0, 50, PETSC_DEFAULT));
  KSP ksp = nullptr;
  check(SNESGetKSP(snes_, &ksp));
  set_scalar_solver_defaults(ksp, "heat_");
  check_substeps();
  check(SNESSetFromOptions(snes_));
  check(SNESGetTolerances(snes_, &residual_tol_, nullptr, nullptr, nullptr, nullptr));
}

void HeatProblem::build_matrix() {
  NodePairs extra;
  for (const ContactHeat& contact : contacts_)
    extra.insert(extra.end(), contact.couplings().begin(), contact.couplings().end());
  assembly_.emplace(d_.scalar, d_.mesh, d_.groups, extra);
  check(SNESSetJacobian(
      snes_, assembly_->matrix(), assembly_->matrix(),
      [](SNES, Vec x, Mat, Mat, void* self) {
        auto& problem = *static_cast<HeatProblem*>(self);
        return problem.mailbox_.guarded([&] { problem.tangent(x); });
      },
      this));
}

void HeatProblem::begin_contacts() {
  if (contacts_.empty()) return;
  bool changed = false;
  for (ContactHeat& contact : contacts_) changed = contact.renew() || changed;
  if (changed) {
    forget_factors();
    build_matrix();
  }
  d_.scalar.to_global(state_.row("theta").committed, residual_);
  for (ContactHeat& contact : contacts_) {
    double rigid = 0;
    if (const auto& theta = contact.contact().settings().rigid_temperature)
      rigid = settings_.theta * theta(t_) + (1 - settings_.theta) * theta(t_n_);
    if (rigid < 0)
      throw UserError(ExitCode::data, "-contact_" + contact.contact().id() +
                                          "_temperature: is negative at t=" + std::to_string(t_) +
                                          "; temperatures are absolute and positive");
    contact.begin(step_.displacement, residual_, t_ - t_n_, settings_.theta, rigid);
  }
}

void HeatProblem::find_regions() {
  // Lane of each cell of this rank.
  std::map<PetscInt, std::array<int, 3>> place;
  const std::vector<int> sources = boundary_.heat_sources();
  if (!sources.empty())
    for (std::size_t g = 0; g < d_.groups.size(); ++g)
      for (int b = 0; b < d_.groups[g].batch_count; ++b)
        for (int l = 0; l < d_.groups[g].lanes_in_use(b); ++l)
          place[d_.groups[g].cell_point[at(b * lanes + l)]] = {static_cast<int>(g), b, l};
  for (int c : sources) {
    std::map<std::pair<int, int>, Batch> inside;
    for (const std::string& name : boundary_.conditions()[at(c)].on)
      for (PetscInt cell : d_.mesh.region_cells(name)) {
        const auto [g, b, l] = place.at(cell);
        inside.try_emplace({g, b}, Batch(0.0)).first->second.set(l, 1.0);
      }
    Region& region = regions_.emplace_back();
    region.condition = c;
    std::size_t size = 0;
    for (const auto& [batch, lanes_inside] : inside) {
      region.cells.push_back({batch.first, batch.second, lanes_inside});
      size += at(point_count(d_.groups[at(batch.first)].shape)) * lanes;
    }
    for (std::vector<double>& source : region.source) source.assign(size, 0.0);
  }
}

HeatRows HeatProblem::rows() {
  HeatRows rows;
  if (moves_ && settings_.form == HeatForm::energy) {
    rows.stress = &state_.row("stress").trial;
    step_stress_.resize(rows.stress->size());
    rows.step_stress = &step_stress_;
  }
  return rows;
}

void HeatProblem::forget_factors() { impact::forget_factors(snes_); }

void HeatProblem::evaluate_loads(double t, int end) {
  for (Region& region : regions_) {
    std::size_t next = 0;
    for (const Region::Cells& cells : region.cells) {
      const CellGroup& group = d_.groups[at(cells.group)];
      with_shape(group, d_.frame, [&]<class Cell, Frame frame>() {
        const Gathered<Cell, Cell::dim> X(group, cells.batch, X_);
        for (int q = 0; q < Cell::points; ++q)
          for (int l = 0; l < lanes; ++l, ++next) {
            if (cells.inside[l] == 0) continue;
            double x[3] = {0, 0, 0};
            for (int a = 0; a < Cell::nodes; ++a)
              for (int k = 0; k < Cell::dim; ++k)
                x[k] += shape_table<Cell>.N[q][a] * X.value[at(a * Cell::dim + k)][l];
            region.source[end][next] = boundary_.heat_value(region.condition, x, t);
          }
      });
    }
  }
  for (Surface& surface : surfaces_) {
    const int c = surface.load->condition;
    const bool convects = boundary_.conditions()[at(c)].type == BcType::convection;
    SurfaceHeat& heat = surface.heat[end];
    for_each_facet_point(surface.load->facets, d_.frame, X_, [&](std::size_t i, const double* x) {
      heat.coefficient[i] = convects ? boundary_.heat_coefficient(c, x, t) : 0.0;
      heat.inflow[i] = (convects ? heat.coefficient[i] * boundary_.ambient_temperature(c, x, t)
                                 : boundary_.heat_value(c, x, t));
    });
  }
}

void HeatProblem::begin(double t_n, double t) {
  t_n_ = t_n;
  t_ = t;
  agree_on_errors(d_.mesh.comm(), [&] {
    if (settings_.theta < 1) evaluate_loads(t_n, 0);
    evaluate_loads(t, 1);
  });
}

namespace {

// What a row is at both ends of a part of the step.
template <class Values> void cut_to(double begin, double end, Values& now, Values& before) {
  for (std::size_t i = 0; i < now.value.size(); ++i) {
    const Batch change = now.value[i] - before.value[i], start = before.value[i];
    now.value[i] = start + end * change;
    before.value[i] = start + begin * change;
  }
}

} // namespace

// body.operator()<Cell, frame>(group, batch, law, input) with the input's arrays at hand.
template <class Body> bool HeatProblem::for_each_batch(const std::vector<double>& theta, Body&& body) {
  const std::vector<double>& theta_n = theta_at_start();
  const auto cut = [this](auto& now, auto& before) {
    if (!window_.whole()) cut_to(window_.begin, window_.end, now, before);
  };
  const StateRow* stress = state_.find("stress");
  const StateRow &history = state_.row("history"), &drive = state_.row("drive");
  const StateRow* fatigue = state_.find("fatigue");
  const bool energy = settings_.form == HeatForm::energy;
  bool sound = true;
  for (std::size_t g = 0; g < d_.groups.size(); ++g) {
    const CellGroup& group = d_.groups[g];
    const PointLaw& law = d_.law(group);
    with_shape(group, d_.frame, [&]<class Cell, Frame frame>() {
      using Points = PointValues<Cell, history_size(frame)>;
      using Stress = PointValues<Cell, gradient_size(frame)>;
      for (int b = 0; b < group.batch_count; ++b) {
        const Gathered<Cell, Cell::dim> X(group, b, X_);
        Gathered<Cell, Cell::dim> u(group, b, step_.u ? *step_.u : X_),
            u_n(group, b, step_.u_n ? *step_.u_n : X_);
        const Gathered<Cell, 1> now(group, b, theta), before(group, b, theta_n);
        Gathered<Cell, 1> phi(group, b, step_.phi ? *step_.phi : theta_n),
            phi_n(group, b, step_.phi_n ? *step_.phi_n : theta_n);
        cut(u, u_n);
        cut(phi, phi_n);
        Points A, A_n;
        PointValues<Cell, drive_size> E, E_n;
        Stress P, P_n;
        PointValues<Cell, 1> dissipation, worn, worn_n;
        HeatInput in;
        in.X = X.data();
        if (step_.u) in.u = u.data(), in.u_n = u_n.data();
        if (step_.phi) in.phi = phi.data(), in.phi_n = phi_n.data();
        if (fatigue && law.fatigues()) {
          worn.load(fatigue->trial, dissipation_offset_[g], b);
          worn_n.load(fatigue->committed, dissipation_offset_[g], b);
          cut(worn, worn_n);
          in.fatigue = worn.data();
          in.fatigue_n = worn_n.data();
        }
        in.theta = now.data();
        in.theta_n = before.data();
        const bool exchanges = !energy && step_.u && step_.phi && law.exchanges();
        if ((energy && flows_) || exchanges || (step_.u && is_ductile(law.parameters)) ||
            (step_.u && d_.frame == Frame::plane_stress)) {
          A.load(history.trial, history_offset_[g], b);
          A_n.load(history.committed, history_offset_[g], b);
          cut(A, A_n);
          in.history = A.data();
          in.history_n = A_n.data();
        }
        if ((energy && law.softens()) || exchanges) {
          E.load(drive.trial, drive_offset_[g], b);
          E_n.load(drive.committed, drive_offset_[g], b);
          if (energy) cut(E, E_n); // the exchange of the entropy form takes that of the end, like damage
          in.drive = E.data();
          in.drive_n = E_n.data();
        }
        if (energy && stress) {
          P.load(step_stress_, stress_offset_[g], b);
          P_n.load(stress->committed, stress_offset_[g], b);
          cut(P, P_n); // linear in time like F: the works of the sub-steps add up to that of the step
          in.stress = P.data();
          in.stress_n = P_n.data();
        }
        if (!energy && step_.dissipation) {
          dissipation.load(*step_.dissipation, dissipation_offset_[g], b);
          if (!window_.whole())
            for (Batch& lost : dissipation.value) lost *= window_.end - window_.begin;
          in.dissipation = dissipation.data();
        }
        in.dt = t_ - t_n_;
        in.theta_h = settings_.theta;
        in.form = settings_.form;
        const int bad = body.template operator()<Cell, frame>(g, b, law, in);
        sound = sound && (bad & ((1 << group.lanes_in_use(b)) - 1)) == 0;
      }
    });
  }
  return sound;
}

bool HeatProblem::make_constant_part() {
  const Timed timed(Event::heat_loads);
  std::fill(constant_.begin(), constant_.end(), 0.0);
  load_supplied_.assign(supplied_.size(), 0.0);
  const double dt = t_ - t_n_;
  const double weight[2] = {(1 - settings_.theta) * dt, settings_.theta * dt};
  const bool sound = for_each_batch(
      x_, [&]<class Cell, Frame frame>(std::size_t g, int b, const PointLaw& law, const HeatInput& in) {
        PointValues<Cell, heat_point_size> points;
        std::array<Batch, at(Cell::nodes)> r{};
        const int bad = heat_step<Cell, frame>(law, in, points.data(), r.data());
        points.store(points_, point_offset_[g], b);
        scatter_add<Cell, 1>(d_.groups[g], b, r.data(), constant_.data());
        return bad;
      });
  load_.assign(constant_.size(), 0.0);
  for (const Region& region : regions_) {
    std::size_t next = 0;
    for (const Region::Cells& cells : region.cells) {
      const CellGroup& group = d_.groups[at(cells.group)];
      with_shape(group, d_.frame, [&]<class Cell, Frame frame>() {
        const Gathered<Cell, Cell::dim> X(group, cells.batch, X_);
        std::array<Batch, at(Cell::points)> source;
        for (Batch& value : source)
          for (int l = 0; l < lanes; ++l, ++next)
            value.set(l, weight[0] * region.source[0][next] + weight[1] * region.source[1][next]);
        std::array<Batch, at(Cell::nodes)> r{};
        Batch sum = 0;
        heat_source<Cell, frame>(X.data(), source.data(), r.data(), sum);
        scatter_add<Cell, 1>(group, cells.batch, r.data(), load_.data());
        load_supplied_[at(region.condition)] += lane_sum(sum, group.lanes_in_use(cells.batch));
      });
    }
  }
  if (settings_.theta < 1)
    for (const Surface& surface : surfaces_)
      load_supplied_[at(surface.load->condition)] += add_surface_heat(
          surface.load->facets, d_.frame, X_, surface.heat[0], theta_at_start(), weight[0], load_);
  for (std::size_t i = 0; i < load_.size(); ++i) constant_[i] -= load_[i];
  return all_ranks_agree(d_.mesh.comm(), sound);
}

bool HeatProblem::add_residual(const std::vector<double>& theta, std::vector<double>& r) {
  r = constant_;
  for (double& value : r) value = -value;
  supplied_ = load_supplied_;
  for (const Surface& surface : surfaces_)
    supplied_[at(surface.load->condition)] += add_surface_heat(
        surface.load->facets, d_.frame, X_, surface.heat[1], theta, settings_.theta * (t_ - t_n_), r);
  for (double& value : r) value = -value;
  const bool sound = for_each_batch(
      theta, [&]<class Cell, Frame frame>(std::size_t g, int b, const PointLaw& law, const HeatInput& in) {
        PointValues<Cell, heat_point_size> points;
        points.load(points_, point_offset_[g], b);
        std::array<Batch, at(Cell::nodes)> part{};
        const int bad = heat_residual<Cell, frame>(law, in, points.data(), part.data());
        scatter_add<Cell, 1>(d_.groups[g], b, part.data(), r.data());
        return bad;
      });
  return all_ranks_agree(d_.mesh.comm(), sound);
}

bool HeatProblem::assemble_residual(const std::vector<double>& theta, Vec solution, Vec f) {
  const Timed timed(Event::heat_residual);
  const bool sound = add_residual(theta, r_);
  check(VecSet(f, 0));
  d_.scalar.add_to_global(r_, f);
  for (const ContactHeat& contact : contacts_) contact.add_residual(solution, f);
  return sound;
}

void HeatProblem::residual(Vec x, Vec f) {
  d_.scalar.to_local(x, x_);
  const bool sound = assemble_residual(x_, x, f);
  zero_owned(f, d_.mesh, 1, owned_held_);
  if (!sound) check(SNESSetFunctionDomainError(snes_));
}

void HeatProblem::tangent(Vec x) {
  const Timed timed(Event::heat_tangent);
  d_.scalar.to_local(x, x_);
  assembly_->zero();
  for_each_batch(
      x_, [&]<class Cell, Frame frame>(std::size_t g, int b, const PointLaw& law, const HeatInput& in) {
        constexpr int n = Cell::nodes;
        PointValues<Cell, heat_point_size> points;
        points.load(points_, point_offset_[g], b);
        const Gathered<Cell, 1> free(d_.groups[g], b, free_);
        std::array<Batch, at(n)> r{};
        std::array<Batch, at(n * n)> K{};
        const int bad = heat_tangent<Cell, frame>(law, in, points.data(), r.data(), K.data());
        for (int i = 0; i < n; ++i)
          for (int j = 0; j < n; ++j) K[at(i * n + j)] *= free.value[at(i)] * free.value[at(j)];
        assembly_->add(static_cast<int>(g), b, K.data());
        return bad;
      });
  assembly_->finish();
  Mat matrix = assembly_->matrix();
  if (!surfaces_.empty() || !contacts_.empty()) {
    if (!contacts_.empty() && !held_nodes_) {
      held_nodes_ = d_.scalar.make_global();
      d_.scalar.to_global(std::vector<double>(held_.begin(), held_.end()), held_nodes_);
    }
    for (const ContactHeat& contact : contacts_) contact.add_tangent(held_nodes_, matrix);
    for (const Surface& surface : surfaces_)
      add_surface_heat_tangent(surface.load->facets, d_.frame, X_, surface.heat[1],
                               settings_.theta * (t_ - t_n_), held_, d_.mesh.global_node(), matrix);
    check(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
    check(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
  }
  double sum = 0;
  check(MatGetDiagonal(matrix, diagonal_));
  check(VecSum(diagonal_, &sum));
  // No residual can fall below what the last digit of a temperature makes of its rows.
  check(VecPointwiseMult(diagonal_, diagonal_, x));
  allow_rounding(snes_, diagonal_);
  assembly_->set_diagonal(owned_held_,
                          sum > 0 ? sum / static_cast<double>(d_.mesh.global_node_count()) : 1.0);
}

// What flows in where the temperature is prescribed is the residual that is left there.
void HeatProblem::book() {
  d_.scalar.to_local(solution_, x_);
  assemble_residual(x_, solution_, residual_);
  d_.scalar.to_local(residual_, r_);
  for (int node : owned_held_) supplied_[at(boundary_.temperature_condition()[at(node)])] += r_[at(node)];
  // Loads of this rank's cells and facets, and what flows in at held nodes: each node's heat at its
  // temperature.
  entropy_supplied_ = 0;
  std::vector<double> heat = load_;
  for (const Surface& surface : surfaces_)
    add_surface_heat(surface.load->facets, d_.frame, X_, surface.heat[1], x_, settings_.theta * (t_ - t_n_),
                     heat);
  for (int node : owned_held_) heat[at(node)] += r_[at(node)];
  if (!contacts_.empty()) {
    // What rigid bodies conducted, at the owners of the nodes.
    check(VecSet(residual_, 0));
    for (std::size_t i = 0; i < contacts_.size(); ++i)
      contact_heat_[i] = contacts_[i].book(solution_, residual_);
    d_.scalar.to_local(residual_, r_);
    for (std::size_t i = 0; i < heat.size(); ++i)
      if (d_.mesh.owned(static_cast<int>(i))) heat[i] += r_[i];
  }
  for (std::size_t i = 0; i < heat.size(); ++i) entropy_supplied_ += heat[i] / x_[i];
  MPI_Allreduce(MPI_IN_PLACE, &entropy_supplied_, 1, MPI_DOUBLE, MPI_SUM, d_.mesh.comm());
  if (!supplied_.empty())
    MPI_Allreduce(MPI_IN_PLACE, supplied_.data(), static_cast<int>(supplied_.size()), MPI_DOUBLE, MPI_SUM,
                  d_.mesh.comm());
}

const std::vector<double>& HeatProblem::theta_at_start() const {
  return window_.begin == 0 ? state_.row("theta").committed : theta_before_;
}

void HeatProblem::check_substeps() {
  if (settings_.substep > 0 && !contacts_.empty())
    throw UserError(ExitCode::usage, "-heat_ts_dt: no sub-steps where heat passes a contact; remove it, or "
                                     "choose a smaller -ts_dt");
}

ScalarOutcome HeatProblem::solve(const HeatStep& step, std::vector<double>& theta) {
  step_ = step;
  // A step that is a whole number of sub-steps but for its last digits is not divided once more.
  const double count = settings_.substep > 0 ? std::ceil((t_ - t_n_) / settings_.substep * (1 - 1e-9)) : 1;
  return count > 1 ? solve_substeps(static_cast<int>(count), theta) : solve_window(theta);
}

ScalarOutcome HeatProblem::solve_substeps(int count, std::vector<double>& theta) {
  const double t_n = t_n_, t = t_;
  std::vector<double> supplied(supplied_.size(), 0.0);
  double entropy_supplied = 0;
  ScalarOutcome sum;
  theta = state_.row("theta").committed;
  for (int k = 0; k < count; ++k) {
    window_ = {double(k) / count, k + 1 == count ? 1 : double(k + 1) / count};
    begin(t_n + window_.begin * (t - t_n), k + 1 == count ? t : t_n + window_.end * (t - t_n));
    theta_before_ = theta;
    const ScalarOutcome part = solve_window(theta);
    sum = {part.reason, sum.newton + part.newton, sum.linear + part.linear, part.cause};
    if (part.reason < 0) break;
    for (std::size_t c = 0; c < supplied.size(); ++c) supplied[c] += supplied_[c];
    entropy_supplied += entropy_supplied_;
  }
  window_ = {};
  begin(t_n, t);
  supplied_ = std::move(supplied);
  entropy_supplied_ = entropy_supplied;
  return sum;
}

// Where it is colder than nothing the points of a cell may still be warm.
void HeatProblem::refuse_below_zero(ScalarOutcome& outcome) const {
  PetscInt row = 0, start = 0, end = 0;
  PetscReal coldest = 0;
  check(VecMin(solution_, &row, &coldest));
  if (coldest > 0) return;
  outcome.reason = SNES_DIVERGED_FUNCTION_DOMAIN;
  double x[3] = {0, 0, 0};
  check(VecGetOwnershipRange(solution_, &start, &end));
  for (int i = 0; row >= start && row < end && i < d_.mesh.node_count(); ++i)
    if (d_.mesh.global_node()[at(i)] == row) std::copy_n(&X_[at(i * d_.dim())], d_.dim(), x);
  MPI_Allreduce(MPI_IN_PLACE, x, 3, MPI_DOUBLE, MPI_SUM, d_.mesh.comm());
  char text[160];
  std::snprintf(text, sizeof(text), "%.6g K at x=(%.6g,%.6g%s", coldest, x[0], x[1],
                d_.dim() == 2 ? ")" : "");
  outcome.cause = text;
  if (d_.dim() == 3) {
    std::snprintf(text, sizeof(text), ",%.6g)", x[2]);
    outcome.cause += text;
  }
}

ScalarOutcome HeatProblem::solve_window(std::vector<double>& theta) {
  agree_on_errors(d_.mesh.comm(), [&] { boundary_.set_temperature(t_, theta); });
  x_ = theta;
  ScalarOutcome outcome;
  if (!make_constant_part()) {
    outcome.reason = SNES_DIVERGED_FUNCTION_DOMAIN;
    return outcome;
  }
  begin_contacts();
  d_.scalar.to_global(theta, solution_);
  check(SNESSetTolerances(snes_, residual_tol_, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  mailbox_.deliver(SNESSolve(snes_, nullptr, solution_));
  outcome.reason = reason_by_residual(snes_);
  check(SNESGetIterationNumber(snes_, &outcome.newton));
  check(SNESGetLinearSolveIterations(snes_, &outcome.linear));
  if (outcome.reason >= 0) refuse_below_zero(outcome);
  if (outcome.reason < 0) return outcome;
  book();
  theta = x_;
  return outcome;
}

} // namespace impact
