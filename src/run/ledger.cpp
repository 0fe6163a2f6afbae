#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <impact/kernel/measure.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/log.hpp>
#include <impact/problem/cell_loop.hpp>
#include <impact/run/ledger.hpp>

namespace impact {

namespace {

// Sum over the owned dofs of a . b; both local arrays.
double dot(const Mesh& mesh, const std::vector<double>& a, const std::vector<double>& b) {
  // A rank may have no nodes at all.
  const auto components = a.size() / static_cast<std::size_t>(std::max(mesh.node_count(), 1));
  double sum = 0;
  for (int node = 0; node < mesh.node_count(); ++node) {
    if (!mesh.owned(node)) continue;
    for (std::size_t k = 0; k < components; ++k) {
      const std::size_t i = static_cast<std::size_t>(node) * components + k;
      sum += a[i] * b[i];
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, mesh.comm());
  return sum;
}

std::vector<double> mean_of(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> mean(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) mean[i] = 0.5 * (a[i] + b[i]);
  return mean;
}

} // namespace

Ledger::Ledger(MotionProblem& motion, StateTable& state, bool inertia, bool moves, LedgerChoice choice)
    : motion_(motion), state_(state), inertia_(inertia), moves_(moves), choice_(choice),
      X_(motion.discretisation().mesh.coordinates().begin(),
         motion.discretisation().mesh.coordinates().end()) {
  const Discretisation& d = motion_.discretisation();
  const auto vertex_row = [&](const char* name) {
    StateRow row{name, Support::vertex, d.dim()};
    return &state_.add(std::move(row), d.node_values(d.dim()));
  };
  StateRow totals{"ledger_totals", Support::global, Total::count};
  totals_ = &state_.add(std::move(totals), Total::count);
  const std::size_t parts = d.materials.size() * static_cast<std::size_t>(losses);
  losses_ = &state_.add({"ledger_materials", Support::global, static_cast<int>(parts)}, parts);
  internal_ = vertex_row("force_internal");
  external_ = vertex_row("force_external");
  contact_ = vertex_row("force_contact");
  inertia_force_ = vertex_row("force_inertia");
  left_ = vertex_row("force_left");
  step_acceleration_ = vertex_row("step_acceleration");
  materials_.resize(d.materials.size());
  const auto& conditions = motion_.boundary().conditions();
  prescribes_damage_ =
      d.has_damage() && std::any_of(conditions.begin(), conditions.end(),
                                    [](const auto& bc) { return bc.type == BcType::damage; });
  if (d.has_heat()) {
    for (const ContactInterface& contact : motion_.contacts())
      if (contact.passes_heat() && moves_) heat_contacts_.push_back(contact.id());
    const std::size_t columns = conditions.size() + 2 * heat_contacts_.size() + 2;
    StateRow row{"ledger_heat", Support::global, static_cast<int>(columns)};
    heat_ = &state_.add(std::move(row), columns);
  }
  mean_theta_.resize(conditions.size());
  reaction_.resize(conditions.size() * static_cast<std::size_t>(d.dim()));
  mean_.resize(reaction_.size());
  moment_.resize(conditions.size() * 3);
  for (const BoundaryCondition& bc : conditions) {
    std::vector<int> nodes;
    for (const std::string& name : bc.on)
      for (int node : d.mesh.nodes(name))
        if (d.mesh.owned(node)) nodes.push_back(node);
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    condition_nodes_.push_back(std::move(nodes));
  }
}

void Ledger::measure(Vec u, Vec v, bool trial) {
  const Discretisation& d = motion_.discretisation();
  std::vector<double> u_local = d.displacement.make_local(), v_local = u_local;
  d.displacement.to_local(u, u_local);
  d.displacement.to_local(v, v_local);
  const auto half = [trial](const StateRow& row) -> const std::vector<double>& {
    return trial ? row.trial : row.committed;
  };
  const StateRow* phi_row = state_.find("phi");
  const StateRow* theta_row = state_.find("theta");
  const StateRow* fatigue_row = state_.find("fatigue");
  const std::vector<double>& history = half(state_.row("history"));
  const std::vector<double>& drive = half(state_.row("drive"));
  const auto offset = point_offsets(d.groups, history_size(d.frame)), one = point_offsets(d.groups, 1),
             drive_offset = point_offsets(d.groups, drive_size);
  constexpr std::size_t columns = 10;
  std::vector<double> values(d.materials.size() * columns, 0.0);
  for (std::size_t g = 0; g < d.groups.size(); ++g) {
    const CellGroup& group = d.groups[g];
    const PointLaw& law = d.law(group);
    double* mine = &values[static_cast<std::size_t>(group.material) * columns];
    with_shape(group, d.frame, [&]<class Cell, Frame frame>() {
      constexpr int dim = Cell::dim;
      for (int b = 0; b < group.batch_count; ++b) {
        const Gathered<Cell, dim> X(group, b, X_), at(group, b, u_local), speed(group, b, v_local);
        std::optional<Gathered<Cell, 1>> phi, theta;
        if (phi_row) phi.emplace(group, b, half(*phi_row));
        if (theta_row) theta.emplace(group, b, half(*theta_row));
        PointValues<Cell, history_size(frame)> points;
        points.load(history, offset[g], b);
        EnergyInput in;
        in.X = X.data();
        in.u = at.data();
        in.v = inertia_ ? speed.data() : nullptr;
        in.phi = phi_row ? phi->data() : nullptr;
        in.theta = theta_row ? theta->data() : nullptr;
        in.history = points.data();
        PointValues<Cell, 1> fatigue;
        if (fatigue_row) {
          fatigue.load(half(*fatigue_row), one[g], b);
          in.fatigue = fatigue.data();
        }
        PointValues<Cell, drive_size> energies;
        if (law.softens()) {
          energies.load(drive, drive_offset[g], b);
          in.drive = energies.data();
        }
        EnergySums sums;
        stored_energy<Cell, frame>(law, in, sums);
        const int used = group.lanes_in_use(b);
        mine[0] += lane_sum(sums.kinetic, used);
        mine[1] += lane_sum(sums.elastic, used);
        mine[2] += lane_sum(sums.plastic, used);
        mine[3] += lane_sum(sums.fracture, used);
        mine[9] += lane_sum(sums.fatigue, used);
        for (int k = 0; k < 3; ++k) mine[4 + k] += lane_sum(sums.momentum[k], used);
        if (!theta_row) continue;
        HeatSums heat;
        stored_heat<Cell, frame>(law, in, heat);
        mine[7] += lane_sum(heat.energy, used);
        mine[8] += lane_sum(heat.entropy, used);
      }
    });
  }
  MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), MPI_DOUBLE, MPI_SUM,
                d.mesh.comm());
  total_ = {};
  for (std::size_t m = 0; m < materials_.size(); ++m) {
    const double* of = &values[m * columns];
    const double w = d.thickness;
    materials_[m] = {w * of[0], w * of[1], w * of[2], w * of[3],
                     w * of[9], w * of[7], w * of[8], {w * of[4], w * of[5], w * of[6]}};
    total_.kinetic += materials_[m].kinetic;
    total_.elastic += materials_[m].elastic;
    total_.plastic += materials_[m].plastic;
    total_.fracture += materials_[m].fracture;
    total_.fatigue += materials_[m].fatigue;
    total_.thermal += materials_[m].thermal;
    total_.entropy += materials_[m].entropy;
  }
  find_extremes(trial);
}

void Ledger::find_extremes(bool trial) {
  const Discretisation& d = motion_.discretisation();
  double extremes[4] = {0, 0, 0, 0};
  if (const StateRow* phi = state_.find("phi"))
    for (double value : trial ? phi->trial : phi->committed) extremes[0] = std::max(extremes[0], value);
  const StateRow& row = state_.row("history");
  const std::vector<double>& history = trial ? row.trial : row.committed;
  const auto components = static_cast<std::size_t>(history_size(d.frame));
  const auto of_alpha = static_cast<std::size_t>(history_alpha(d.frame));
  for (std::size_t i = of_alpha * lanes; i < history.size(); i += components * lanes)
    for (std::size_t l = 0; l < lanes; ++l) extremes[1] = std::max(extremes[1], history[i + l]);
  if (const StateRow* theta = state_.find("theta"))
    for (double value : trial ? theta->trial : theta->committed) extremes[2] = std::max(extremes[2], value);
  if (const StateRow* fatigue = state_.find("fatigue"))
    for (double value : trial ? fatigue->trial : fatigue->committed)
      extremes[3] = std::max(extremes[3], value);
  MPI_Allreduce(MPI_IN_PLACE, extremes, 4, MPI_DOUBLE, MPI_MAX, d.mesh.comm());
  fatigue_max_ = extremes[3];
  theta_max_ = extremes[2];
  phi_max_ = extremes[0];
  alpha_max_ = extremes[1];
}

double Ledger::contact_energy(Vec u) const {
  double energy = 0;
  for (ContactInterface& contact : motion_.contacts()) energy += contact.measures(u).energy;
  return energy;
}

double Ledger::stored() const {
  return total_.kinetic + total_.elastic + total_.plastic + total_.fracture + total_.fatigue +
         total_.thermal + energy_contact_ + sum(kept);
}

void Ledger::start(const Integrator& integrator, double dt, Vec u, Vec v, Vec a) {
  const Discretisation& d = motion_.discretisation();
  measure(u, v, false);
  energy_contact_ = contact_energy(u);
  sum(contact_store) = energy_contact_;
  sum(start_energy) = stored();
  if (heat_) heat_->trial.back() = total_.entropy;
  sum(scale) = std::abs(sum(start_energy));
  // Forces of the start: the half of the first step's work that belongs to t = 0.
  ForceParts parts;
  motion_.parts(u, parts);
  d.displacement.to_local(parts.internal, internal_->trial);
  d.displacement.to_local(parts.external, external_->trial);
  if (inertia_) {
    // M a_0 balances these forces on the free dofs, contact apart.
    const Handle<Vec> Ma = d.displacement.make_global();
    motion_.mass_multiply(a, Ma);
    d.displacement.to_local(Ma, inertia_force_->trial);
    sum(kept) = d.thickness * integrator.kept_at_start(dt, a, Ma);
    sum(kept_at_start) = sum(kept);
    sum(start_energy) = stored();
  }
  // Statics knows no load that is put on at once: what the start lacks to balance grows in the first step.
  for (std::size_t i = 0; i < internal_->trial.size(); ++i)
    if (!inertia_ || motion_.boundary().fixed_mask()[i])
      external_->trial[i] = inertia_force_->trial[i] + internal_->trial[i];
  reaction_force_ = internal_->trial;
  std::vector<double> loads = d.displacement.make_local();
  d.displacement.to_local(parts.external, loads);
  std::vector<double> unilateral = d.displacement.make_local();
  if (parts.unilateral) d.displacement.to_local(parts.unilateral, unilateral);
  for (std::size_t i = 0; i < loads.size(); ++i) reaction_force_[i] += unilateral[i] - loads[i];
  std::vector<double> local = d.displacement.make_local();
  d.displacement.to_local(u, local);
  find_reactions(local);
}

void Ledger::observe(Vec u, Vec v) {
  measure(u, v, false);
  for (double& total : totals_->trial) total = NAN;
  reaction_force_.assign(motion_.discretisation().node_values(motion_.discretisation().dim()), NAN);
  std::vector<double> local = motion_.discretisation().displacement.make_local();
  motion_.discretisation().displacement.to_local(u, local);
  find_reactions(local);
}

void Ledger::resume(Vec u, Vec v) {
  reaction_force_ = motion_.discretisation().displacement.make_local();
  measure(u, v, false);
  energy_contact_ = contact_energy(u);
}

// dt times the forces S of the projection strike the bodies at the start of a step. M (v_start - v_n) is that
// on free dofs; what it is beside that comes from supports, and in rigid bodies also from what keeps them so.
Ledger::Shock Ledger::find_shock(const StepRecord& step) const {
  const double dt = step.dt;
  const Discretisation& d = motion_.discretisation();
  Shock shock;
  double size = 0;
  check(VecNorm(step.contact_shock, NORM_INFINITY, &size));
  if (size == 0) return shock;
  const Handle<Vec> u_n = global_of("u"), v_n = global_of("v"), mean = d.displacement.make_global(),
                    jump = d.displacement.make_global(), beside = d.displacement.make_global();
  const Vec v_start = step.start_velocity;
  check(VecWAXPY(jump, -1, v_n, v_start));
  motion_.mass_multiply(jump, beside);
  check(VecAXPY(beside, -dt, step.contact_shock));
  check(VecWAXPY(mean, 0.5, jump, v_n));
  std::vector<double> speed = d.displacement.make_local(), force = speed, other = speed;
  d.displacement.to_local(mean, speed);
  d.displacement.to_local(step.contact_shock, force);
  d.displacement.to_local(beside, other);
  std::vector<double> held = other;
  for (std::size_t i = 0; i < speed.size(); ++i) {
    if (!motion_.boundary().fixed_mask()[i]) held[i] = 0;
    if (!in_rigid_body(i)) other[i] = 0;
  }
  const double of_bodies = d.thickness * dt * motion_.rigid().strike_power(step.contact_shock, u_n, v_n);
  shock.contact = d.thickness * dt * dot(d.mesh, speed, force);
  shock.supports = d.thickness * dot(d.mesh, speed, held) + of_bodies;
  shock.rigid = d.thickness * dot(d.mesh, speed, other) - of_bodies;
  return shock;
}

// The scheme's own energy; the inertia that the step balanced goes into its row.
IntegratorEnergy Ledger::find_integrator_energy(const StepRecord& step, Vec u, Vec v, Vec a) {
  const Discretisation& d = motion_.discretisation();
  const Integrator& weights = step.integrator;
  const Handle<Vec> du = global_of("u"), a_n = global_of("a"), df = global_of("step_acceleration"),
                    struck = global_of("v"), lag = d.displacement.make_global(),
                    f = d.displacement.make_global();
  const auto times_mass = [&](Vec of) {
    Handle<Vec> force = d.displacement.make_global();
    motion_.mass_multiply(of, force);
    return force;
  };
  check(VecAYPX(du, -1, u));
  check(VecAXPY(f, 2 * weights.beta, step.contact_acceleration));
  check(VecAYPX(df, -1, f));
  check(VecAYPX(struck, -1, step.start_velocity));
  d.displacement.to_local(f, step_acceleration_->trial);
  const Handle<Vec> Ma_n = times_mass(a_n), Ma = times_mass(a), Mf = times_mass(f), Mdf = times_mass(df);
  d.displacement.to_global(inertia_force_->committed, lag);
  check(VecAXPY(lag, -1, Ma_n));
  const IntegratorEnergy energy = weights.energy({.dt = step.dt,
                                                  .du = du,
                                                  .v_start = step.start_velocity,
                                                  .v = v,
                                                  .a_n = a_n,
                                                  .a = a,
                                                  .f = f,
                                                  .df = df,
                                                  .Ma_n = Ma_n,
                                                  .Ma = Ma,
                                                  .Mf = Mf,
                                                  .Mdf = Mdf,
                                                  .lag = lag,
                                                  .struck = struck,
                                                  .grown = sum(grown) / d.thickness});
  check(VecAXPBY(Ma, 1 - weights.alpha_m, weights.alpha_m, Ma_n));
  d.displacement.to_local(Ma, inertia_force_->trial);
  const double w = d.thickness;
  return {w * energy.loss, w * energy.kept, w * energy.grown, w * energy.exchange};
}

void Ledger::book(const StepRecord& step, Vec u, Vec v, Vec a) {
  const Timed timed(Event::balances);
  const Discretisation& d = motion_.discretisation();
  const double w = d.thickness;
  const bool stabilised = step.stabilised, parted = stabilised || step.unilateral;
  const double kinetic_n = total_.kinetic;
  total_before_ = total_;
  materials_before_ = materials_;

  // Forces at t_{n+1} as the motion solve used them: frozen phi, committed history.
  const ForceParts& parts = *step.forces;
  d.displacement.to_local(parts.internal, internal_->trial);
  d.displacement.to_local(parts.external, external_->trial);
  d.displacement.to_local(step.contact_force, contact_->trial);
  d.displacement.to_local(step.left, left_->trial);
  // m tau- of broken points acts over the step as a whole, like the stabilised contact.
  std::vector<double> unilateral = d.displacement.make_local();
  if (parts.unilateral) d.displacement.to_local(parts.unilateral, unilateral);
  IntegratorEnergy integrator;
  Shock shock;
  double work_rigid = 0;
  std::vector<double> corrected = d.displacement.make_local();
  if (inertia_) {
    integrator = find_integrator_energy(step, u, v, a);
    shock = find_shock(step);
    const double beta = step.integrator.beta, alpha_m = step.integrator.alpha_m;
    // What acts on displacement and velocity as one force over the step: the share of a_c, twice beta of it
    // in M a_c. That is the force of stabilised contact less that of closing cracks; of rigid bodies also
    // what keeps them rigid, and the reactions there.
    Handle<Vec> a_eq = global_of("a"), force = d.displacement.make_global();
    motion_.mass_multiply(step.contact_acceleration, force);
    check(VecScale(force, parted ? 2 * beta : alpha_m));
    d.displacement.to_local(force, corrected);
    check(VecScale(a_eq, 1 - alpha_m));
    check(VecAXPY(a_eq, alpha_m, a));
    check(VecAXPY(a_eq, alpha_m, step.contact_acceleration));
    work_rigid = w * motion_.book_rigid_reactions(u, a_eq, 2 * beta / alpha_m);
  } else {
    work_rigid = w * motion_.book_rigid_reactions(u, nullptr, 1);
  }
  // What closes the balance on held dofs is the support's: a mean of both ends, and of what acts over the
  // step a part that does so too.
  std::vector<double> over_step = d.displacement.make_local();
  reaction_force_.resize(over_step.size());
  for (std::size_t i = 0; i < over_step.size(); ++i) {
    const double contact = contact_->trial[i],
                 of_step = corrected[i] + unilateral[i] - (stabilised ? contact : 0),
                 at_end = inertia_force_->trial[i] + internal_->trial[i] - external_->trial[i] -
                          (stabilised ? 0 : contact);
    reaction_force_[i] = at_end + of_step;
    if (in_rigid_body(i)) {
      left_->trial[i] = 0; // holds resultants
      if (!inertia_) inertia_force_->trial[i] = external_->trial[i] + contact_->trial[i];
    }
    if (!motion_.boundary().fixed_mask()[i]) continue;
    external_->trial[i] += parted ? at_end : reaction_force_[i];
    if (parted) over_step[i] = of_step;
  }

  std::vector<double> u_local = d.displacement.make_local();
  d.displacement.to_local(u, u_local);
  std::vector<double> du = u_local;
  const std::vector<double>& u_n = state_.row("u").committed;
  for (std::size_t i = 0; i < du.size(); ++i) du[i] -= u_n[i];
  const double work_internal = w * dot(d.mesh, du, mean_of(internal_->committed, internal_->trial));
  const double work_external = w * dot(d.mesh, du, mean_of(external_->committed, external_->trial)) +
                               w * dot(d.mesh, du, over_step) + work_rigid + shock.supports;
  const double work_contact =
      w * dot(d.mesh, du, stabilised ? contact_->trial : mean_of(contact_->committed, contact_->trial));

  const double work_unilateral = w * dot(d.mesh, du, unilateral);
  measure(u, v, true);
  energy_contact_ = contact_energy(u);
  const double kinetic_change = total_.kinetic - kinetic_n;
  const double work_left = w * dot(d.mesh, du, mean_of(left_->committed, left_->trial));
  // Without inertia the arms of a rigid body's forces belong to the end of the step, and their work to no
  // one.
  const double of_arms =
      inertia_ ? 0
               : work_rigid + w * dot(d.mesh, du, mean_of(inertia_force_->committed, inertia_force_->trial));
  sum(external) += work_external;
  // What contact takes from bodies and obstacles, and neither keeps nor rubs into heat: the stabilised update
  // closes gaps against the pressure of the step's end and strikes the bodies, as a plastic impact does.
  double taken = -work_contact - shock.contact - shock.rigid - (energy_contact_ - sum(contact_store));
  for (const ContactInterface& contact : motion_.contacts()) {
    const ObstacleWork of_obstacle = contact.obstacle_work(u, stabilised);
    const double rubbed = contact.friction_loss(u);
    sum(external) += of_obstacle.force + of_obstacle.shock;
    sum(friction) += rubbed;
    sum(contact_loss) += contact.released_energy(u);
    taken += of_obstacle.force + of_obstacle.shock - rubbed;
  }
  if (stabilised) sum(contact_loss) += taken;
  sum(contact_store) = energy_contact_;
  sum(contact_work) += work_contact;
  sum(numerical) += integrator.loss - (integrator.kept - sum(kept));
  sum(kept) = integrator.kept;
  sum(grown) = integrator.grown;
  sum(exchange) += integrator.exchange;
  sum(unbalanced) += work_left;
  if (step.unilateral) sum(closing) += work_unilateral - w * unilateral_energy(step.phi);
  sum(identity) += kinetic_change + integrator.loss + work_internal + work_unilateral - work_external -
                   work_contact - shock.contact - shock.rigid - work_left + of_arms;
  const MotionProblem::Increments& increments = *step.increments;
  sum(viscous) += w * increments.viscous_dissipation;
  sum(plastic_dissipation) += w * increments.plastic_dissipation;
  sum(least) = std::min(sum(least), increments.least_dissipation);
  for (std::size_t m = 0; m < increments.viscous_part.size(); ++m) {
    lost_in(m, viscous_loss) += w * increments.viscous_part[m];
    lost_in(m, plastic_loss) += w * increments.plastic_part[m];
  }
  if (state_.find("phi")) book_damage(step);
  sum(least) = std::min(sum(least), step.least_fatigue);
  for (std::size_t m = 0; m < step.fatigue_dissipation.size(); ++m) {
    lost_in(m, fatigue_part) += w * step.fatigue_dissipation[m];
    sum(fatigue_loss) += w * step.fatigue_dissipation[m];
  }
  if (choice_.coupling_error) find_coupling_error(step.internal_of_next_pass, parts.internal);
  if (heat_) {
    const std::span<const double> supplied = step.heat_supplied;
    for (std::size_t c = 0; c < supplied.size(); ++c) heat_->trial[c] += w * supplied[c];
    const std::span<const ContactHeat::Heat> contacts = step.contact_heat;
    for (std::size_t c = 0; c < contacts.size(); ++c) {
      double* columns = &heat_->trial[supplied.size() + 2 * c];
      columns[0] += w * contacts[c].conducted;
      columns[1] += w * contacts[c].outside;
    }
    heat_->trial[heat_->trial.size() - 2] += w * step.entropy_supplied;
  }
  sum(scale) = std::max({sum(scale), std::abs(stored() - sum(kept)), std::abs(sum(external)),
                         std::abs(sum(start_energy) - sum(kept_at_start))});
  if (heat_) sum(scale) = std::max(sum(scale), std::abs(heat_supplied()));
  find_reactions(u_local);
}

// What the unilateral stress stores in the step, at the damage that its force saw; not times the thickness.
double Ledger::unilateral_energy(std::span<const double> phi) const {
  const Discretisation& d = motion_.discretisation();
  StateRow &history = state_.row("history"), &drive = state_.row("drive");
  const auto flow_at = point_offsets(d.groups, history_size(d.frame)),
             drive_at = point_offsets(d.groups, drive_size);
  std::vector<double> before_step = drive.committed;
  if (heat_) { // at the temperature that the force saw, too
    const std::vector<double> flow = history.trial, driving = drive.trial;
    MotionProblem::Increments unused;
    motion_.advance(global_of("u"), unused);
    before_step = drive.trial;
    history.trial = flow;
    drive.trial = driving;
  }
  double sum = 0;
  for (std::size_t g = 0; g < d.groups.size(); ++g) {
    const CellGroup& group = d.groups[g];
    const PointLaw& law = d.law(group);
    if (law.parameters.damage == Damage::none) continue;
    with_shape(group, d.frame, [&]<class Cell, Frame frame>() {
      for (int b = 0; b < group.batch_count; ++b) {
        const Gathered<Cell, Cell::dim> X(group, b, X_);
        const Gathered<Cell, 1> seen(group, b, phi);
        PointValues<Cell, history_size(frame)> flowed;
        PointValues<Cell, drive_size> after, before;
        flowed.load(history.committed, flow_at[g], b);
        after.load(drive.trial, drive_at[g], b);
        before.load(before_step, drive_at[g], b);
        Batch part = 0;
        impact::unilateral_energy<Cell, frame>(law, X.data(), seen.data(), flowed.data(), after.data(),
                                               before.data(), part);
        sum += lane_sum(part, group.lanes_in_use(b));
      }
    });
  }
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, d.mesh.comm());
  return sum;
}

void Ledger::book_damage(const StepRecord& step) {
  const Discretisation& d = motion_.discretisation();
  const StateRow &phi = state_.row("phi"), &history = state_.row("history"), &drive = state_.row("drive");
  const auto flow_at = point_offsets(d.groups, history_size(d.frame)),
             drive_at = point_offsets(d.groups, drive_size), at = point_offsets(d.groups, 1);
  const double w = d.thickness;
  double smallest = 0;
  const std::size_t materials = materials_.size();
  std::vector<double> lost(2 * materials, 0.0); // by damage; by the exchange of damage and flow
  for (std::size_t g = 0; g < d.groups.size(); ++g) {
    const CellGroup& group = d.groups[g];
    const PointLaw& law = d.law(group);
    if (law.parameters.damage == Damage::none) continue;
    const auto material = static_cast<std::size_t>(group.material);
    with_shape(group, d.frame, [&]<class Cell, Frame frame>() {
      for (int b = 0; b < group.batch_count; ++b) {
        const Gathered<Cell, Cell::dim> X(group, b, X_);
        PointValues<Cell, 1> by_damage, all, exchanged;
        by_damage.load(step.damage_dissipation, at[g], b);
        all = by_damage;
        const int used = group.lanes_in_use(b);
        lost[material] += lane_sum(cell_integral<Cell, frame>(X.data(), by_damage.data()), used);
        if (law.exchanges()) {
          all.load(step.dissipation, at[g], b);
          const Gathered<Cell, 1> now(group, b, phi.trial), before(group, b, phi.committed);
          PointValues<Cell, history_size(frame)> flowed, flowed_n;
          PointValues<Cell, drive_size> driving;
          flowed.load(history.trial, flow_at[g], b);
          flowed_n.load(history.committed, flow_at[g], b);
          driving.load(drive.trial, drive_at[g], b);
          plastic_exchange<Cell, frame>(
              law, {now.data(), before.data(), flowed.data(), flowed_n.data(), driving.data()},
              exchanged.data());
          lost[materials + material] +=
              lane_sum(cell_integral<Cell, frame>(X.data(), exchanged.data()), used);
          for (std::size_t q = 0; q < all.value.size(); ++q) all.value[q] += exchanged.value[q];
        }
        for (const Batch& at_point : all.value)
          for (int l = 0; l < used; ++l) smallest = std::min(smallest, at_point[l]);
      }
    });
  }
  MPI_Allreduce(MPI_IN_PLACE, lost.data(), static_cast<int>(lost.size()), MPI_DOUBLE, MPI_SUM, d.mesh.comm());
  MPI_Allreduce(MPI_IN_PLACE, &smallest, 1, MPI_DOUBLE, MPI_MIN, d.mesh.comm());
  sum(least) = std::min(sum(least), smallest);
  for (std::size_t m = 0; m < materials; ++m) {
    sum(damage) += w * lost[m];
    sum(plastic_dissipation) += w * lost[materials + m];
    lost_in(m, damage_loss) += w * lost[m];
    lost_in(m, plastic_loss) += w * lost[materials + m];
  }
  const double work = w * step.prescribed_damage_work;
  sum(damage_work) += work;
  sum(external) += work;
}

// On free dofs the change of the internal forces is the residual of a next pass, elsewhere that of the
// reactions.
void Ledger::find_coupling_error(Vec internal_of_next_pass, Vec internal) {
  PetscReal change = 0, size = 0;
  const Handle<Vec> difference = motion_.discretisation().displacement.make_global();
  check(VecWAXPY(difference, -1, internal, internal_of_next_pass));
  check(VecNorm(difference, NORM_2, &change));
  check(VecNorm(internal, NORM_2, &size));
  coupling_error_ = size > 0 ? change / size : 0;
}

void Ledger::unbook() {
  total_ = total_before_;
  materials_ = materials_before_;
}

void Ledger::find_reactions(const std::vector<double>& u) {
  const Discretisation& d = motion_.discretisation();
  const auto dim = static_cast<std::size_t>(d.dim());
  std::fill(reaction_.begin(), reaction_.end(), 0.0);
  for (const FixedDof& fixed : motion_.boundary().fixed()) {
    if (!d.mesh.owned(fixed.dof / d.dim())) continue;
    const auto i = static_cast<std::size_t>(fixed.dof);
    reaction_[static_cast<std::size_t>(fixed.condition) * dim + static_cast<std::size_t>(fixed.component)] +=
        d.thickness * reaction_force_[i];
  }
  std::fill(moment_.begin(), moment_.end(), 0.0);
  const RigidBodies& rigid = motion_.rigid();
  int rank = 0;
  MPI_Comm_rank(d.mesh.comm(), &rank);
  for (std::size_t b = 0; b < rigid.bodies().size(); ++b)
    for (std::size_t k = 0; k < 6; ++k) {
      const int c = rigid.bodies()[b].held[k];
      if (c < 0) continue;
      const double value = d.thickness * rigid.reactions(static_cast<int>(b))[k];
      if (k >= 3)
        moment_[static_cast<std::size_t>(c) * 3 + k - 3] += value;
      else if (k < dim && rank == 0) // the same on all ranks, which are summed below
        reaction_[static_cast<std::size_t>(c) * dim + k] += value;
    }
  std::vector<double> sums(mean_.size() + 2 * condition_nodes_.size(), 0.0);
  const StateRow* theta = state_.find("theta");
  for (std::size_t c = 0; c < condition_nodes_.size(); ++c) {
    for (int node : condition_nodes_[c])
      for (std::size_t k = 0; k < dim; ++k) sums[c * dim + k] += u[static_cast<std::size_t>(node) * dim + k];
    sums[mean_.size() + c] = static_cast<double>(condition_nodes_[c].size());
    if (theta)
      for (int node : condition_nodes_[c])
        sums[mean_.size() + condition_nodes_.size() + c] += theta->trial[static_cast<std::size_t>(node)];
  }
  MPI_Allreduce(MPI_IN_PLACE, reaction_.data(), static_cast<int>(reaction_.size()), MPI_DOUBLE, MPI_SUM,
                d.mesh.comm());
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, d.mesh.comm());
  for (std::size_t c = 0; c < condition_nodes_.size(); ++c)
    for (std::size_t k = 0; k < dim; ++k)
      mean_[c * dim + k] = sums[c * dim + k] / std::max(1.0, sums[mean_.size() + c]);
  for (std::size_t c = 0; c < condition_nodes_.size(); ++c)
    mean_theta_[c] = sums[mean_.size() + condition_nodes_.size() + c] / std::max(1.0, sums[mean_.size() + c]);
}

double Ledger::energy_scale() const { return sum(scale) > 0 ? sum(scale) : sum(scale) + 1e-300; }
double Ledger::balance() const { return sum(identity) / energy_scale(); }

double Ledger::dissipated() const {
  const double lost = sum(numerical) + sum(contact_loss);
  // The rest is thermal energy; of closing cracks where the heat balance takes the work of the stress.
  if (heat_) return state_.find("stress") ? lost : lost + sum(closing);
  return lost + sum(viscous) + sum(damage) + sum(plastic_dissipation) + sum(friction) + sum(fatigue_loss) +
         sum(closing);
}

double Ledger::heat_supplied() const {
  double total = 0;
  if (!heat_) return total;
  const std::size_t conditions = motion_.boundary().conditions().size();
  for (std::size_t c = 0; c < conditions; ++c) total += heat_->trial[c];
  for (std::size_t c = 0; c < heat_contacts_.size(); ++c) total += heat_->trial[conditions + 2 * c + 1];
  return total;
}

double Ledger::entropy_produced() const {
  const std::size_t n = heat_->trial.size();
  return total_.entropy - heat_->trial[n - 2] - heat_->trial[n - 1];
}

double Ledger::balance_first_law() const {
  return (stored() + dissipated() - sum(external) - heat_supplied() - sum(start_energy)) / energy_scale();
}

double Ledger::gain() const {
  const double lost = sum(contact_loss) + sum(closing) + sum(numerical);
  return std::max({0.0, -sum(contact_loss), -std::max(lost, lost + sum(kept) - sum(kept_at_start))});
}

double Ledger::energy_error() const {
  const double gained = gain() / energy_scale();
  const double residual = balance_first_law();
  return residual > -gained ? std::max(0.0, residual) + gained : residual;
}

void Ledger::append_energies(HistoryFile::Row& row) const {
  const Discretisation& d = motion_.discretisation();
  const auto& contacts = motion_.contacts();
  const bool has_contact = !contacts.empty();
  const bool has_friction =
      std::any_of(contacts.begin(), contacts.end(), [](const auto& contact) { return contact.frictional(); });
  const bool heat = d.has_heat();
  if (moves_) row.emplace_back("energy_kinetic", total_.kinetic);
  if (moves_ || d.has_damage()) row.emplace_back("energy_elastic", total_.elastic);
  if (d.has_plasticity()) row.emplace_back("energy_plastic", total_.plastic);
  if (d.has_damage()) row.emplace_back("energy_fracture", total_.fracture);
  if (d.has_fatigue()) row.emplace_back("energy_fatigue", total_.fatigue);
  if (heat) row.emplace_back("energy_thermal", total_.thermal);
  if (d.has_viscosity()) row.emplace_back("dissipated_viscous", sum(viscous));
  if (d.has_damage()) row.emplace_back("dissipated_damage", sum(damage));
  if (d.has_plasticity()) row.emplace_back("dissipated_plastic", sum(plastic_dissipation));
  if (has_friction) row.emplace_back("dissipated_friction", sum(friction));
  if (d.has_fatigue()) row.emplace_back("dissipated_fatigue", sum(fatigue_loss));
  if (has_contact) row.emplace_back("energy_contact", energy_contact_);
  if (has_contact && inertia_) row.emplace_back("dissipated_contact", sum(contact_loss));
  if (choice_.unilateral) row.emplace_back("dissipated_closing", sum(closing));
  if (inertia_) row.emplace_back("energy_numerical", sum(kept));
  if (moves_) row.emplace_back("dissipated_numerical", sum(numerical));
  if (inertia_) row.emplace_back("exchange_numerical", sum(exchange));
  if (inertia_) row.emplace_back("gain", gain());
  if (moves_) row.emplace_back("work_external", sum(external));
  if (prescribes_damage_) row.emplace_back("work_damage", sum(damage_work));
  if (has_contact) row.emplace_back("work_contact", sum(contact_work));
  if (heat) row.emplace_back("heat_supplied", heat_supplied());
  if (heat) row.emplace_back("entropy_produced", entropy_produced());
  if (moves_) row.emplace_back("balance", balance());
  row.emplace_back("balance_first_law", balance_first_law());
  if (choice_.coupling_error) row.emplace_back("coupling_error", coupling_error_);
  if (d.has_damage()) row.emplace_back("phi_max", phi_max_);
  if (d.has_plasticity()) row.emplace_back("alpha_max", alpha_max_);
  if (heat) row.emplace_back("theta_max", theta_max_);
  if (d.has_fatigue()) row.emplace_back("fatigue_max", fatigue_max_);
}

void Ledger::append_reactions(HistoryFile::Row& row) const {
  static constexpr const char* axis[3] = {"x", "y", "z"};
  const int dim = motion_.discretisation().dim();
  const auto& conditions = motion_.boundary().conditions();
  for (std::size_t c = 0; c < conditions.size(); ++c) {
    const BcType type = conditions[c].type;
    if (type == BcType::body_force || type == BcType::damage) continue;
    if (is_thermal(type)) {
      row.emplace_back("heat_" + conditions[c].id, heat_->trial[c]);
      row.emplace_back("mean_" + conditions[c].id + "_theta", mean_theta_[c]);
      continue;
    }
    const bool holds = type == BcType::fix || type == BcType::displacement || type == BcType::symmetry ||
                       type == BcType::velocity || type == BcType::acceleration;
    for (int k = 0; k < dim; ++k) {
      const std::size_t i = c * static_cast<std::size_t>(dim) + static_cast<std::size_t>(k);
      if (holds) row.emplace_back("reaction_" + conditions[c].id + "_" + axis[k], reaction_[i]);
    }
    for (std::size_t k = 0; k < 3; ++k)
      if (turns(static_cast<int>(c), k))
        row.emplace_back("moment_" + conditions[c].id + "_" + axis[k], moment_[3 * c + k]);
    for (int k = 0; k < dim; ++k) {
      const std::size_t i = c * static_cast<std::size_t>(dim) + static_cast<std::size_t>(k);
      row.emplace_back("mean_" + conditions[c].id + "_u" + axis[k], mean_[i]);
    }
  }
}

void Ledger::append_contact_heat(HistoryFile::Row& row) const {
  const std::size_t conditions = motion_.boundary().conditions().size();
  for (std::size_t c = 0; c < heat_contacts_.size(); ++c)
    row.emplace_back("heat_contact_" + heat_contacts_[c], heat_->trial[conditions + 2 * c]);
}

bool Ledger::turns(int condition, std::size_t axis) const {
  const auto& bodies = motion_.rigid().bodies();
  return std::any_of(bodies.begin(), bodies.end(),
                     [&](const RigidBody& body) { return body.held[3 + axis] == condition; });
}

Handle<Vec> Ledger::global_of(const char* row) const {
  const FieldLayout& layout = motion_.discretisation().displacement;
  Handle<Vec> values = layout.make_global();
  layout.to_global(state_.row(row).committed, values);
  return values;
}

bool Ledger::in_rigid_body(std::size_t dof) const {
  const std::vector<int>& body = motion_.rigid().body_of_node();
  return !body.empty() && body[dof / static_cast<std::size_t>(motion_.discretisation().dim())] >= 0;
}

void Ledger::append_materials(HistoryFile::Row& row) const {
  static constexpr const char* axis[3] = {"x", "y", "z"};
  const Discretisation& d = motion_.discretisation();
  for (std::size_t m = 0; m < materials_.size(); ++m) {
    const std::string& id = d.materials[m].law.parameters.id;
    if (d.has_heat()) row.emplace_back("energy_thermal_" + id, materials_[m].thermal);
    if (!moves_) continue;
    for (int k = 0; k < d.dim(); ++k)
      row.emplace_back("momentum_" + id + "_" + axis[k], materials_[m].momentum[k]);
    row.emplace_back("energy_kinetic_" + id, materials_[m].kinetic);
    row.emplace_back("energy_elastic_" + id, materials_[m].elastic);
    if (d.has_plasticity()) row.emplace_back("energy_plastic_" + id, materials_[m].plastic);
    if (!choice_.materials) continue;
    if (d.has_damage()) row.emplace_back("energy_fracture_" + id, materials_[m].fracture);
    if (d.has_fatigue()) row.emplace_back("energy_fatigue_" + id, materials_[m].fatigue);
    if (d.has_viscosity()) row.emplace_back("dissipated_viscous_" + id, lost_in(m, viscous_loss));
    if (d.has_damage()) row.emplace_back("dissipated_damage_" + id, lost_in(m, damage_loss));
    if (d.has_plasticity()) row.emplace_back("dissipated_plastic_" + id, lost_in(m, plastic_loss));
    if (d.has_fatigue()) row.emplace_back("dissipated_fatigue_" + id, lost_in(m, fatigue_part));
  }
}

std::string Ledger::report() const {
  const Discretisation& d = motion_.discretisation();
  const auto& contacts = motion_.contacts();
  const std::size_t number = materials_.size();
  std::string text;
  char cell[64];
  const auto line = [&](const char* name, double total, const std::function<double(std::size_t)>& part) {
    std::snprintf(cell, sizeof(cell), "  %-30s %12.5g", name, total);
    text += cell;
    for (std::size_t m = 0; part && number > 1 && m < number; ++m) {
      std::snprintf(cell, sizeof(cell), " %12.5g", part(m));
      text += cell;
    }
    text += "\n";
  };
  const auto stored_line = [&](const char* name, double MaterialEnergies::*member) {
    line(name, total_.*member, [&](std::size_t m) { return materials_[m].*member; });
  };
  const auto loss_line = [&](const char* name, Total total, Loss which) {
    line(name, sum(total), [&, which](std::size_t m) { return lost_in(m, which); });
  };
  std::snprintf(cell, sizeof(cell), "%-32s %12s", "energy since t = 0", "total");
  text += cell;
  for (std::size_t m = 0; number > 1 && m < number; ++m) {
    std::snprintf(cell, sizeof(cell), " %12.12s", d.materials[m].law.parameters.id.c_str());
    text += cell;
  }
  text += "\n";
  if (moves_) line("work of loads and supports", sum(external), {});
  if (prescribes_damage_) line("of that of prescribed phi", sum(damage_work), {});
  if (heat_) line("heat supplied", heat_supplied(), {});
  line("at the start", sum(start_energy), {});
  if (inertia_) stored_line("stored: kinetic", &MaterialEnergies::kinetic);
  if (moves_) stored_line("stored: elastic", &MaterialEnergies::elastic);
  if (d.has_plasticity()) stored_line("stored: plastic", &MaterialEnergies::plastic);
  if (d.has_damage()) stored_line("stored: fracture", &MaterialEnergies::fracture);
  if (d.has_fatigue()) stored_line("stored: fatigue", &MaterialEnergies::fatigue);
  if (heat_) stored_line("stored: thermal", &MaterialEnergies::thermal);
  if (!contacts.empty()) line("stored: contact", energy_contact_, {});
  if (inertia_) line("stored: integrator", sum(kept), {});
  const char* const became = heat_ ? " (heat)" : "";
  const auto name = [&](const char* kind) { return std::string("dissipated: ") + kind + became; };
  if (d.has_viscosity()) loss_line(name("viscous").c_str(), viscous, viscous_loss);
  if (d.has_damage()) loss_line(name("damage").c_str(), damage, damage_loss);
  if (d.has_plasticity()) loss_line(name("plastic").c_str(), plastic_dissipation, plastic_loss);
  if (d.has_fatigue()) loss_line(name("fatigue").c_str(), fatigue_loss, fatigue_part);
  if (std::any_of(contacts.begin(), contacts.end(), [](const auto& contact) { return contact.frictional(); }))
    line("dissipated: friction", sum(friction), {});
  if (!contacts.empty() && inertia_) line("dissipated: contact", sum(contact_loss), {});
  if (choice_.unilateral)
    line(state_.find("stress") ? name("closing cracks").c_str() : "dissipated: closing cracks", sum(closing),
         {});
  if (moves_) line("dissipated: integrator", sum(numerical), {});
  if (moves_) line("work of unbalanced forces", sum(unbalanced), {});
  line("first-law residual", balance_first_law() * energy_scale(), {});
  line("smallest dissipation at a point", sum(least), {});
  return text;
}

} // namespace impact
