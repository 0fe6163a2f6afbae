#include <algorithm>
#include <cmath>
#include <impact/contact/interface.hpp>
#include <impact/petsc/error.hpp>
#include <limits>

/// What a ContactInterface does after a solve: multipliers, totals, history columns, output fields.
namespace impact {

namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// The penalty's rule: a gap that fell by less than this factor makes the penalty grow.
constexpr double wanted_fall = 4;
// By how much it grows where no increment is given: in proportion, so that a start far too low is soon made
// up for.
constexpr double growth_factor = 4;
// The semismooth method has converged when its active gaps are less than this part of a facet.
constexpr double newton_gap = 1e-11;

} // namespace

// The force on the secondary side.
void ContactInterface::add_force(const Constraint& c, std::array<double, 3>& force) const {
  if (!c.active) return;
  const double t = traction(c).value;
  for (std::size_t i = 0; i < at(dim_) * c.share.size(); ++i)
    force[i % at(dim_)] += c.weight * (c.pressure * c.gradient[i] - (t != 0 ? t * c.slip_gradient[i] : 0));
}

std::array<double, 3> ContactInterface::total_force(Vec u) const {
  std::array<double, 3> force{};
  visit(form_->nodes().displacement(u), Derivatives::first,
        [&](const Constraint& c) { add_force(c, force); });
  MPI_Allreduce(MPI_IN_PLACE, force.data(), 3, MPI_DOUBLE, MPI_SUM, mesh_->comm());
  if (step_.under_way) // what the trapezoidal rule makes the mean of
    for (std::size_t k = 0; k < at(dim_); ++k) force[k] = 2 * force[k] - totals_->committed[at(dim_) + 1 + k];
  return force;
}

double ContactInterface::friction_loss(Vec u) const {
  if (!frictional()) return 0;
  double loss = 0;
  visit(form_->nodes().displacement(u), Derivatives::none, [&](const Constraint& c) {
    const Traction t = traction(c);
    if (t.direction == 0) return;
    const double elastic = semismooth() ? 0 : (t.value - traction_->trial[at(c.index)]) / penalty();
    loss += c.weight * t.value * (c.slip - elastic);
  });
  MPI_Allreduce(MPI_IN_PLACE, &loss, 1, MPI_DOUBLE, MPI_SUM, mesh_->comm());
  return reported_thickness() * loss;
}

double ContactInterface::obstacle_work(Vec u, bool force_at_end) const {
  const std::array<double, 3> moved = pose_at(time_).moved;
  if (moved == std::array<double, 3>{}) return 0; // at rest, or no rigid body: no force is asked for
  const std::array<double, 3> force = total_force(u);
  double work = 0;
  for (std::size_t k = 0; k < at(dim_); ++k) {
    const double before = totals_->committed[at(dim_) + 1 + k];
    work += moved[k] * (force_at_end ? force[k] : (before + force[k]) / 2);
  }
  return reported_thickness() * work;
}

void ContactInterface::share(std::vector<double>& multipliers) const {
  if (multiplier_->support != Support::vertex) return;
  // One constraint per node, evaluated by the node's owner.
  std::vector<double> pairs = layout_->make_local();
  const auto d = at(dim_);
  for (std::size_t node = 0; node < multipliers.size(); ++node) pairs[d * node] = multipliers[node];
  const Handle<Vec> owned = layout_->make_global();
  layout_->to_global(pairs, owned);
  layout_->to_local(owned, pairs);
  for (std::size_t node = 0; node < multipliers.size(); ++node) multipliers[node] = pairs[d * node];
}

void ContactInterface::start_augmentation() { penalty_->trial[1] = 0; }

AugmentReport ContactInterface::propose(Vec u, std::vector<double>& lambda,
                                        std::vector<double>& traction) const {
  // A constraint that faces nothing carries nothing.
  lambda.assign(multiplier_->trial.size(), 0.0);
  traction.assign(traction_ != nullptr ? lambda.size() : 0, 0.0);
  AugmentReport report;
  const ContactStatus status =
      visit(form_->nodes().displacement(u), Derivatives::none, [&](const Constraint& c) {
        lambda[at(c.index)] = std::max(0.0, c.pressure);
        if (traction_ != nullptr) traction[at(c.index)] = this->traction(c).value;
        // An opening point fades out with its pressure: its gap would count or not by the last digit of p.
        if (c.active)
          report.largest_gap =
              std::max(report.largest_gap, std::min(std::abs(c.gap), c.pressure / penalty()));
        if (c.active && c.gap < form_->deepest()) report.settled = false;
      });
  share(lambda);
  if (traction_ != nullptr) share(traction);
  if (form_->switched()) report.settled = false;
  double change = 0;
  for (std::size_t i = 0; i < lambda.size(); ++i) {
    report.multiplier = std::max(report.multiplier, lambda[i]);
    change = std::max(change, std::abs(lambda[i] - multiplier_->trial[i]));
  }
  for (std::size_t i = 0; i < traction.size(); ++i)
    change = std::max(change, std::abs(traction[i] - traction_->trial[i]));
  std::array<double, 5> largest = {status.penetration, report.settled ? 0.0 : 1.0, report.multiplier, change,
                                   report.largest_gap};
  MPI_Allreduce(MPI_IN_PLACE, largest.data(), 5, MPI_DOUBLE, MPI_MAX, mesh_->comm());
  MPI_Allreduce(&status.active, &report.active, 1, MPI_INT, MPI_SUM, mesh_->comm());
  report.penetration = largest[0];
  report.largest_gap = largest[4];
  report.settled = largest[1] == 0;
  report.multiplier = largest[2];
  // Multipliers of rounding size (touch exactly at a step) never settle relative to each other.
  const double negligible = 1e-9 * penalty() * settings_.search_radius;
  report.change = largest[3] > 0 ? largest[3] / std::max(largest[2], negligible) : 0;
  report.penalty = penalty();
  switch (settings_.enforce) {
  case Enforcement::penalty:
    report.converged = report.settled;
    break;
  case Enforcement::semismooth:
    if (!fallen_back_) {
      report.converged = report.settled && gaps_closed(u);
      break;
    }
    [[fallthrough]];
  case Enforcement::automatic:
  case Enforcement::auglag:
    report.converged =
        report.settled && report.penetration < settings_.gap_tol && report.change < settings_.pressure_tol;
  }
  return report;
}

bool ContactInterface::gaps_closed(Vec u, double force) const {
  if (!semismooth()) return true;
  const std::vector<double> values = form_->nodes().displacement(u);
  // Gap or slip that must vanish; the largest force that closing one takes; coordinate.
  std::array<double, 3> largest = {0, 0, 0};
  visit(values, Derivatives::none, [&](const Constraint& c) {
    if (!c.active) return;
    double open = std::abs(c.gap);
    if (rubs(c) && traction(c).direction == 0) open = std::max(open, std::abs(c.slip));
    largest[0] = std::max(largest[0], open);
    largest[1] = std::max(largest[1], c.weight * penalty() * open);
  });
  for (double coordinate : form_->nodes().current(values))
    largest[2] = std::max(largest[2], std::abs(coordinate));
  MPI_Allreduce(MPI_IN_PLACE, largest.data(), 3, MPI_DOUBLE, MPI_MAX, mesh_->comm());
  const bool rounding = largest[0] <= 1e-14 * largest[2];
  return rounding || (largest[0] <= newton_gap * mean_length_ && largest[1] <= force);
}

AugmentReport ContactInterface::review(Vec u) const {
  std::vector<double> lambda, traction;
  return propose(u, lambda, traction);
}

AugmentReport ContactInterface::augment(Vec u) {
  std::vector<double> lambda, traction;
  const AugmentReport report = propose(u, lambda, traction);
  form_->clear_switched(); // another solve follows
  if (settings_.enforce == Enforcement::penalty) return report;
  multiplier_->trial = std::move(lambda);
  if (traction_ != nullptr && !friction_suspended_) traction_->trial = std::move(traction);
  if (semismooth()) return report;
  const double before = penalty_->trial[1];
  const bool slow = before > 0 && report.largest_gap > before / wanted_fall;
  if (settings_.growth == PenaltyGrowth::every_augmentation || slow) {
    const double now = penalty_->trial[0];
    const double more =
        std::isnan(settings_.penalty_increment) ? (growth_factor - 1) * now : settings_.penalty_increment;
    penalty_->trial[0] = std::max(now, std::min(now + more, settings_.penalty_max));
  }
  penalty_->trial[1] = report.largest_gap;
  return report;
}

void ContactInterface::advance(Vec u_n, Vec u, double dt) {
  const Handle<Vec> f = layout_->make_global(), f_n = layout_->make_global(), du = layout_->make_global();
  add_residual(u, 1, f);
  layout_->to_local(f, force_->trial);
  layout_->to_global(force_->committed, f_n);
  check(VecWAXPY(du, -1, u_n, u));
  check(VecAXPY(f, 1, f_n));
  double twice_work = 0;
  check(VecDot(f, du, &twice_work));
  const std::array<double, 3> force = total_force(u);
  const std::vector<double>& before = totals_->committed;
  const auto d = at(dim_);
  for (std::size_t k = 0; k < d; ++k) {
    totals_->trial[k] = before[k] + dt * (before[d + 1 + k] + force[k]) / 2;
    totals_->trial[d + 1 + k] = force[k];
  }
  totals_->trial[d] = before[d] - twice_work / 2;
  const std::array<double, 3> obstacle = obstacle_displacement(time_);
  std::copy(obstacle.begin(), obstacle.end(), totals_->trial.begin() + 2 * dim_ + 1);
  if (conserving()) keep_gaps(u);
  if (traction_ == nullptr) return;
  // What sticks from now on does so with the traction of this state.
  std::vector<double> lambda, traction;
  propose(u, lambda, traction);
  traction_->trial = std::move(traction);
  form_->anchor(u);
}

ContactMeasures ContactInterface::measures(Vec u) const {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const double eps = penalty();
  std::array<double, 6> sum{}; // force, length, energy, active
  std::array<double, 3> largest = {-infinity, 0,
                                   -infinity}; // minus smallest gap, pressure, minus smallest pressure
  visit(form_->nodes().displacement(u), Derivatives::first, [&](const Constraint& c) {
    largest[0] = std::max(largest[0], -c.gap);
    // Multipliers that hold g = 0 exactly store nothing.
    if (!semismooth()) sum[4] += c.weight * contact_potential(c.lambda, eps, c.gap);
    if (!c.active) return;
    const Traction t = traction(c);
    // A penalty keeps the traction's energy too; augmentations take it for a multiplier.
    if (settings_.enforce == Enforcement::penalty) sum[4] += c.weight * t.value * t.value / (2 * eps);
    std::array<double, 3> force{};
    add_force(c, force);
    for (std::size_t k = 0; k < 3; ++k) sum[k] += force[k];
    sum[3] += c.weight * c.stretch;
    sum[5] += 1;
    largest[1] = std::max(largest[1], c.pressure / c.stretch);
    largest[2] = std::max(largest[2], -c.pressure / c.stretch);
  });
  MPI_Allreduce(MPI_IN_PLACE, sum.data(), 6, MPI_DOUBLE, MPI_SUM, mesh_->comm());
  MPI_Allreduce(MPI_IN_PLACE, largest.data(), 3, MPI_DOUBLE, MPI_MAX, mesh_->comm());
  const double thick = reported_thickness();
  ContactMeasures m;
  for (std::size_t k = 0; k < at(dim_); ++k) {
    m.force[k] = thick * sum[k];
    m.impulse[k] = thick * totals_->trial[k];
  }
  m.length = sum[3];
  m.energy = thick * sum[4];
  m.active = static_cast<int>(sum[5]);
  m.gap_min = std::isinf(largest[0]) ? std::numeric_limits<double>::quiet_NaN() : -largest[0];
  m.pressure_max = largest[1];
  m.pressure_min = m.active > 0 ? -largest[2] : 0;
  m.work = thick * totals_->trial[at(dim_)];
  return m;
}

void ContactInterface::nodal_fields(Vec u, std::vector<double>& pressure, std::vector<double>& gap) const {
  // By nodes: reference area times pressure; area times gap, and that area, over the constraints that face
  // something.
  const ContactNodes& nodes = form_->nodes();
  const auto d = at(dim_);
  std::vector<double> p(d * nodes.global.size(), 0.0), g(p.size(), 0.0);
  visit(nodes.displacement(u), Derivatives::none, [&](const Constraint& c) {
    for (std::size_t a = 0; a < c.share.size(); ++a) {
      const double weight = c.weight * c.share[a];
      const std::size_t i = d * at(c.node[a]);
      p[i] += weight * c.pressure / c.stretch;
      g[i] += weight * c.gap;
      g[i + 1] += weight;
    }
  });
  std::vector<double> local_p = layout_->make_local(), local_g = layout_->make_local();
  for (auto [mine, local] : {std::pair{&p, &local_p}, std::pair{&g, &local_g}}) {
    const Handle<Vec> sum = layout_->make_global();
    nodes.exchange.add(*mine, sum);
    layout_->to_local(sum, *local);
  }
  const auto count = at(mesh_->node_count());
  pressure.assign(count, 0.0);
  gap.assign(count, std::numeric_limits<double>::quiet_NaN());
  for (std::size_t node = 0; node < count; ++node) {
    if (form_->nodal_area()[node] > 0) pressure[node] = local_p[d * node] / form_->nodal_area()[node];
    if (local_g[d * node + 1] > 0) gap[node] = local_g[d * node] / local_g[d * node + 1];
  }
}

} // namespace impact
