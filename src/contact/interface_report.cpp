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

} // namespace

void ContactInterface::start_augmentation() { penalty_->trial[1] = 0; }

AugmentReport ContactInterface::propose(Vec u, std::vector<double>& lambda) const {
  ContactStatus status;
  // A point that faces nothing carries nothing.
  lambda.assign(multiplier_->trial.size(), 0.0);
  AugmentReport report;
  for (const ContactPoint& point : points(u, &status)) {
    lambda[at(point.index)] = point.pressure;
    // An opening point fades out with its pressure: its gap would count or not by the last digit of p.
    report.largest_gap =
        std::max(report.largest_gap, std::min(std::abs(point.foot.gap), point.pressure / penalty()));
    if (point.pressure > 0 && !against_plane() && point.foot.gap < -search_.radius) report.settled = false;
  }
  if (switched_) report.settled = false;
  double change = 0;
  for (std::size_t i = 0; i < lambda.size(); ++i) {
    report.multiplier = std::max(report.multiplier, lambda[i]);
    change = std::max(change, std::abs(lambda[i] - multiplier_->trial[i]));
  }
  std::array<double, 5> largest = {status.penetration, report.settled ? 0.0 : 1.0, report.multiplier, change,
                                   report.largest_gap};
  MPI_Allreduce(MPI_IN_PLACE, largest.data(), 5, MPI_DOUBLE, MPI_MAX, mesh_->comm());
  MPI_Allreduce(&status.active, &report.active, 1, MPI_INT, MPI_SUM, mesh_->comm());
  report.penetration = largest[0];
  report.largest_gap = largest[4];
  report.settled = largest[1] == 0;
  report.multiplier = largest[2];
  // Multipliers of rounding size (touch exactly at a step) never settle relative to each other.
  const double negligible = 1e-9 * penalty() * search_.radius;
  report.change = largest[3] > 0 ? largest[3] / std::max(largest[2], negligible) : 0;
  report.penalty = penalty();
  report.converged =
      report.settled && (settings_.enforce == Enforcement::penalty ||
                         (report.penetration < settings_.gap_tol && report.change < settings_.pressure_tol));
  return report;
}

AugmentReport ContactInterface::review(Vec u) const {
  std::vector<double> lambda;
  return propose(u, lambda);
}

AugmentReport ContactInterface::augment(Vec u) {
  std::vector<double> lambda;
  const AugmentReport report = propose(u, lambda);
  switched_ = false; // another solve follows
  if (settings_.enforce == Enforcement::penalty) return report;
  multiplier_->trial = std::move(lambda);
  const double before = penalty_->trial[1];
  const bool slow = before > 0 && report.largest_gap > before / wanted_fall;
  if (settings_.growth == PenaltyGrowth::every_augmentation || slow)
    penalty_->trial[0] =
        std::max(penalty_->trial[0],
                 std::min(penalty_->trial[0] + settings_.penalty_increment, settings_.penalty_max));
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
  std::array<double, 2> force{};
  for (const ContactPoint& point : points(u, nullptr))
    for (std::size_t k = 0; k < 2; ++k) force[k] += point.weight * point.pressure * point.foot.normal[k];
  MPI_Allreduce(MPI_IN_PLACE, force.data(), 2, MPI_DOUBLE, MPI_SUM, mesh_->comm());
  const std::vector<double>& before = totals_->committed;
  totals_->trial = {before[0] + dt * (before[3] + force[0]) / 2, before[1] + dt * (before[4] + force[1]) / 2,
                    before[2] - twice_work / 2, force[0], force[1]};
}

ContactMeasures ContactInterface::measures(Vec u) const {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const double eps = penalty();
  std::array<double, 5> sum{}; // force x y, length, energy, active
  std::array<double, 3> largest = {-infinity, 0,
                                   -infinity}; // minus smallest gap, pressure, minus smallest pressure
  for (const ContactPoint& point : points(u, nullptr)) {
    largest[0] = std::max(largest[0], -point.foot.gap);
    sum[3] += point.weight * contact_potential(point.lambda, eps, point.foot.gap);
    if (!(point.pressure > 0)) continue;
    for (std::size_t k = 0; k < 2; ++k) sum[k] += point.weight * point.pressure * point.foot.normal[k];
    sum[2] += point.weight * point.stretch;
    sum[4] += 1;
    largest[1] = std::max(largest[1], point.pressure / point.stretch);
    largest[2] = std::max(largest[2], -point.pressure / point.stretch);
  }
  MPI_Allreduce(MPI_IN_PLACE, sum.data(), 5, MPI_DOUBLE, MPI_SUM, mesh_->comm());
  MPI_Allreduce(MPI_IN_PLACE, largest.data(), 3, MPI_DOUBLE, MPI_MAX, mesh_->comm());
  const double thick = environment_.frame == Frame::axisymmetric ? 1 : environment_.thickness;
  ContactMeasures m;
  m.force = {thick * sum[0], thick * sum[1]};
  m.length = sum[2];
  m.energy = thick * sum[3];
  m.active = static_cast<int>(sum[4]);
  m.gap_min = std::isinf(largest[0]) ? std::numeric_limits<double>::quiet_NaN() : -largest[0];
  m.pressure_max = largest[1];
  m.pressure_min = m.active > 0 ? -largest[2] : 0;
  m.impulse = {thick * totals_->trial[0], thick * totals_->trial[1]};
  m.work = thick * totals_->trial[2];
  return m;
}

void ContactInterface::nodal_fields(Vec u, std::vector<double>& pressure, std::vector<double>& gap) const {
  // Sums of weight times pressure and weight over all points of the facets at a node; of gap over those that
  // face.
  std::vector<double> p = layout_->make_local(), g = layout_->make_local();
  for (int f = 0; f < secondary_.surface.count(); ++f)
    for (int q = 0; q < points_.per_facet; ++q)
      for (int a = 0; a < 2; ++a) {
        const int index = f * points_.per_facet + q;
        p[at(2 * secondary_.surface.local[at(2 * f + a)] + 1)] +=
            points_.weight[at(index)] * points_.shape[at(2 * index + a)];
      }
  for (const ContactPoint& point : points(u, nullptr))
    for (int a = 0; a < 2; ++a) {
      const int node = secondary_.surface.local[at(2 * point.facet + a)];
      const double weight = point.weight * point.shape[at(a)];
      p[at(2 * node)] += weight * point.pressure / point.stretch;
      g[at(2 * node)] += weight * point.foot.gap;
      g[at(2 * node + 1)] += weight;
    }
  for (std::vector<double>* field : {&p, &g}) {
    const Handle<Vec> sum = layout_->make_global();
    layout_->add_to_global(*field, sum);
    layout_->to_local(sum, *field);
  }
  const auto count = at(mesh_->node_count());
  pressure.assign(count, 0.0);
  gap.assign(count, std::numeric_limits<double>::quiet_NaN());
  for (std::size_t node = 0; node < count; ++node) {
    if (p[2 * node + 1] > 0) pressure[node] = p[2 * node] / p[2 * node + 1];
    if (g[2 * node + 1] > 0) gap[node] = g[2 * node] / g[2 * node + 1];
  }
}

} // namespace impact
