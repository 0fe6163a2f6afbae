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
// The semismooth method has converged when its active gaps are less than this part of a facet.
constexpr double newton_gap = 1e-11;

} // namespace

// The force on the secondary side.
void ContactInterface::add_force(const Constraint& c, std::array<double, 3>& force) const {
  if (!c.active) return;
  const std::size_t n = c.gradient.size(), mine = at(dim_) * c.share.size();
  for (std::size_t i = 0; i < mine; ++i) force[i % at(dim_)] += c.weight * c.pressure * c.gradient[i];
  if (!rubs(c)) return;
  const Tangential t = traction(c).value;
  for (std::size_t a = 0; a < tangents(); ++a)
    for (std::size_t i = 0; i < mine; ++i)
      force[i % at(dim_)] -= c.weight * t[a] * c.slip_gradient[n * a + i];
}

std::array<double, 3> ContactInterface::total_force(Vec u) const {
  std::array<double, 3> force{};
  visit(form_->nodes().displacement(u), Derivatives::first,
        [&](const Constraint& c) { add_force(c, force); });
  MPI_Allreduce(MPI_IN_PLACE, force.data(), 3, MPI_DOUBLE, MPI_SUM, mesh_->comm());
  if (exact_work()) // what the trapezoidal rule makes the mean of
    for (std::size_t k = 0; k < at(dim_); ++k) force[k] = 2 * force[k] - totals_->committed[at(dim_) + 1 + k];
  return force;
}

void ContactInterface::add_frictional_heat(const Constraint& c, double& heat) const {
  if (exact_work()) {
    heat += c.weight * step_traction(c).loss;
    return;
  }
  const Traction t = traction(c);
  if (!t.slides) return;
  const Tangential before = held(c);
  for (std::size_t a = 0; a < tangents(); ++a) {
    const double elastic = semismooth() ? 0 : (t.value[a] - before[a]) / penalty();
    heat += c.weight * t.value[a] * (c.slip[a] - elastic);
  }
}

double ContactInterface::friction_loss(Vec u) const {
  if (!frictional()) return 0;
  double loss = 0;
  visit(form_->nodes().displacement(u), Derivatives::none,
        [&](const Constraint& c) { add_frictional_heat(c, loss); });
  MPI_Allreduce(MPI_IN_PLACE, &loss, 1, MPI_DOUBLE, MPI_SUM, mesh_->comm());
  return reported_thickness() * loss;
}

HeatPaths ContactInterface::heat_paths(Vec u) const {
  struct Heat {
    double conductance = 0, friction = 0; // per reference area, and of the place
  };
  std::vector<Heat> heat(multiplier_->trial.size());
  const std::vector<double> values = form_->nodes().displacement(u);
  visit(values, Derivatives::none, [&](const Constraint& c) {
    Heat& here = heat[at(c.index)];
    if (frictional()) add_frictional_heat(c, here.friction);
    if (c.active && c.pressure > 0)
      here.conductance = c.stretch * settings_.conductance_at(c.pressure / c.stretch);
  });
  HeatPaths paths;
  const auto place = step_.rule == StepRule::none ? values : place_of_gradients(values);
  form_->visit_meetings(place, [&](const Meeting& meeting) {
    const Heat& here = heat[at(meeting.index)];
    if (here.conductance == 0 && here.friction == 0) return;
    paths.conductance.push_back(meeting.area * here.conductance);
    paths.friction.push_back(here.friction);
    paths.secondary.push_back(meeting.secondary);
    paths.node.insert(paths.node.end(), meeting.node.begin(), meeting.node.end());
    paths.share.insert(paths.share.end(), meeting.share.begin(), meeting.share.end());
    paths.first.push_back(paths.node.size());
  });
  return paths;
}

ObstacleWork ContactInterface::obstacle_work(Vec u, bool force_at_end) const {
  const std::array<double, 3> moved = pose_at(time_).moved;
  if (moved == std::array<double, 3>{}) return {}; // at rest, or no rigid body: no force is asked for
  const std::array<double, 3> force = total_force(u);
  ObstacleWork work;
  for (std::size_t k = 0; k < at(dim_); ++k) {
    const double before = totals_->committed[at(dim_) + 1 + k];
    work.force += reported_thickness() * moved[k] * (force_at_end ? force[k] : (before + force[k]) / 2);
    if (force_at_end) work.shock += reported_thickness() * moved[k] * step_.shock[k];
  }
  return work;
}

void ContactInterface::share(std::vector<double>& values, int components) const {
  if (multiplier_->support != Support::vertex) return;
  // One constraint per node, evaluated by the node's owner.
  std::vector<double> vectors = layout_->make_local();
  const auto d = at(dim_), n = at(components);
  for (std::size_t i = 0; i < values.size(); ++i) vectors[d * (i / n) + i % n] = values[i];
  const Handle<Vec> owned = layout_->make_global();
  layout_->to_global(vectors, owned);
  layout_->to_local(owned, vectors);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = vectors[d * (i / n) + i % n];
}

void ContactInterface::start_augmentation() {
  penalty_->trial[1] = 0;
  last_change_ = HUGE_VAL;
}

double ContactInterface::largest_of(const std::vector<double>& nodal) const {
  const Handle<Vec> sum = layout_->make_global();
  check(VecSet(sum, 0));
  form_->nodes().exchange.add(nodal, sum);
  double largest = 0;
  check(VecNorm(sum, NORM_INFINITY, &largest));
  return largest;
}

AugmentReport ContactInterface::propose(Vec u, std::vector<double>& lambda,
                                        std::vector<double>& traction) const {
  // A constraint that faces nothing carries nothing.
  lambda.assign(multiplier_->trial.size(), 0.0);
  traction.assign(traction_ != nullptr ? tangents() * lambda.size() : 0, 0.0);
  AugmentReport report;
  // What the change of the multipliers does to the bodies, and all that they do.
  const std::vector<double> values = form_->nodes().displacement(u);
  std::vector<double> change(values.size(), 0.0), force(values.size(), 0.0);
  const auto m = at(dim_);
  double widest = 0;
  const bool by_force = at_rest_ && augments();
  const ContactStatus status =
      visit(values, by_force ? Derivatives::first : Derivatives::none, [&](const Constraint& c) {
        const double p = std::max(0.0, c.pressure), before = multiplier_->trial[at(c.index)];
        lambda[at(c.index)] = p;
        const std::size_t n = c.gradient.size();
        const auto act = [&](double now, double then, std::span<const double> gradient) {
          for (std::size_t i = 0; i < n; ++i) {
            const std::size_t row = dof(c.node[i / m], i % m);
            if (fixed_here_[row]) continue;
            force[row] += c.weight * now * gradient[i];
            change[row] += c.weight * (now - then) * gradient[i];
          }
        };
        if (p != 0 || before != 0) act(p, before, c.gradient);
        if (traction_ != nullptr) {
          const Tangential t = traction_to_keep(c);
          std::copy_n(t.begin(), tangents(), &traction[tangents() * at(c.index)]);
          if (c.slides)
            for (std::size_t a = 0; a < tangents(); ++a)
              act(-t[a], -traction_->trial[tangents() * at(c.index) + a], c.slip_gradient.subspan(n * a, n));
        }
        // An opening point fades out with its pressure: its gap would count or not by the last digit of p.
        if (c.active)
          report.largest_gap =
              std::max(report.largest_gap, std::min(std::abs(c.gap), c.pressure / penalty()));
        if (c.active && c.gap < form_->deepest()) report.settled = false;
        widest = std::max(widest, c.weight);
      });
  share(lambda, 1);
  if (traction_ != nullptr) share(traction, dim_ - 1);
  if (form_->switched()) report.settled = false;
  double most = 0;
  for (std::size_t i = 0; i < lambda.size(); ++i) {
    report.multiplier = std::max(report.multiplier, lambda[i]);
    most = std::max(most, std::abs(lambda[i] - multiplier_->trial[i]));
  }
  for (std::size_t i = 0; i < traction.size(); ++i)
    most = std::max(most, std::abs(traction[i] - traction_->trial[i]));
  std::array<double, 6> largest = {
      status.penetration, report.settled ? 0.0 : 1.0, report.multiplier, widest, report.largest_gap, most};
  MPI_Allreduce(MPI_IN_PLACE, largest.data(), 6, MPI_DOUBLE, MPI_MAX, mesh_->comm());
  MPI_Allreduce(&status.active, &report.active, 1, MPI_INT, MPI_SUM, mesh_->comm());
  report.penetration = largest[0];
  report.largest_gap = largest[4];
  report.settled = largest[1] == 0;
  report.multiplier = largest[2];
  // Multipliers of rounding size (touch exactly at a step) never settle relative to each other.
  const double negligible = 1e-9 * penalty() * settings_.search_radius;
  const auto relative = [](double part, double of) { return part > 0 ? part / of : 0; };
  report.change = relative(largest[5], std::max(largest[2], negligible));
  // Constraints that are more than the surfaces can meet share a force in many ways, and go on changing. With
  // inertia every change left is energy.
  double of_force = report.change;
  if (by_force && report.change > last_change_ / 2 && report.penetration < settings_.gap_tol / 10)
    of_force = relative(largest_of(change), std::max(largest_of(force), negligible * largest[3]));
  report.penalty = penalty();
  switch (settings_.enforce) {
  case Enforcement::penalty:
    report.converged = report.settled;
    break;
  case Enforcement::semismooth:
    if (semismooth()) {
      report.converged = report.settled && gaps_left(u).open <= most_open;
      break;
    }
    [[fallthrough]];
  case Enforcement::automatic:
  case Enforcement::auglag:
    report.converged = report.settled && report.penetration < settings_.gap_tol &&
                       std::min(report.change, of_force) < settings_.pressure_tol;
  }
  return report;
}

ContactInterface::GapsLeft ContactInterface::gaps_left(Vec u, double force) const {
  if (!semismooth()) return {};
  const std::vector<double> values = form_->nodes().displacement(u);
  // Gap or slip that must vanish; the largest force that closing one takes; coordinate.
  std::array<double, 3> largest = {0, 0, 0};
  visit(values, Derivatives::none, [&](const Constraint& c) {
    if (!c.active) return;
    double open = std::abs(c.gap), force_of_turn = 0;
    if (rubs(c)) {
      const Traction t = traction(c);
      const Tangential& s = c.slip;
      if (!t.slides) open = std::max(open, std::hypot(s[0], s[1]));
      // Slip across the traction: it must turn until there is none.
      if (t.slides && dim_ == 3) {
        const double across = std::abs(t.direction[0] * s[1] - t.direction[1] * s[0]);
        force_of_turn = c.weight * turn_stiffness(c, t) * across;
        largest[0] = std::max(largest[0], across);
      }
    }
    largest[0] = std::max(largest[0], open);
    largest[1] = std::max({largest[1], c.weight * penalty() * open, force_of_turn});
  });
  for (double coordinate : form_->nodes().current(values))
    largest[2] = std::max(largest[2], std::abs(coordinate));
  MPI_Allreduce(MPI_IN_PLACE, largest.data(), 3, MPI_DOUBLE, MPI_MAX, mesh_->comm());
  const bool rounding = largest[0] <= 1e-14 * largest[2];
  return {rounding || (largest[0] <= newton_gap * mean_length_ && largest[1] <= force),
          largest[0] / mean_length_};
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
  last_change_ = report.change;
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
  const bool stabilised = step_.rule == StepRule::middle;
  if (stabilised)
    check(VecScale(f, 2));
  else
    check(VecAXPY(f, 1, f_n));
  double twice_work = 0;
  check(VecDot(f, du, &twice_work));
  const std::array<double, 3> force = total_force(u);
  const std::vector<double>& before = totals_->committed;
  const auto d = at(dim_);
  for (std::size_t k = 0; k < d; ++k) {
    const double mean = stabilised ? force[k] + step_.shock[k] : (before[d + 1 + k] + force[k]) / 2;
    totals_->trial[k] = before[k] + dt * mean;
    totals_->trial[d + 1 + k] = force[k];
  }
  totals_->trial[d] = before[d] - twice_work / 2;
  const std::array<double, 3> obstacle = obstacle_displacement(time_);
  std::copy(obstacle.begin(), obstacle.end(), totals_->trial.begin() + 2 * dim_ + 1);
  if (conserving()) totals_->trial[at(2 * dim_ + 4)] = spring_energy(u);
  if (traction_ != nullptr) keep_tractions(u);
  if (conserving()) keep_gaps(u);
  step_.rule = StepRule::none;
  if (traction_ != nullptr) form_->anchor(u);
}

void ContactInterface::keep_tractions(Vec u) {
  totals_->trial.back() = totals_->committed.back() + friction_loss(u) / reported_thickness();
  // What sticks from now on does so with the traction of this state.
  std::vector<double> lambda, traction, slip(slip_->trial.size(), 0.0);
  propose(u, lambda, traction);
  const std::size_t n = tangents() + 1;
  visit(form_->nodes().displacement(u), Derivatives::none, [&](const Constraint& c) {
    if (!c.active) return;
    double* mine = &slip[n * at(c.index)];
    for (std::size_t a = 0; a < tangents(); ++a) mine[a] = slip_->committed[n * at(c.index) + a] + c.slip[a];
    // What has closed just now had no friction yet.
    mine[n - 1] = !c.slides || this->traction(c).slides ? 2 : 1;
  });
  share(slip, dim_);
  slip_->trial = std::move(slip);
  traction_->trial = std::move(traction);
}

ContactInterface::Reach ContactInterface::reach(Vec u) const {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const double touch = 1e-6 * mean_length_;
  const std::vector<double> values = form_->nodes().displacement(u);
  std::array<double, 3> most = {-infinity, 0, -infinity}; // minus gap, whether it presses, minus distance
  double stiffness = 0;
  visit(values, Derivatives::none, [&](const Constraint& c) {
    most[0] = std::max(most[0], -c.gap);
    if (c.active) most[1] = 1;
    if (c.gap < touch) stiffness += c.weight * penalty();
  });
  if (most[0] == -infinity) most[2] = -form_->nearest_nodes(values);
  MPI_Allreduce(MPI_IN_PLACE, most.data(), 3, MPI_DOUBLE, MPI_MAX, mesh_->comm());
  MPI_Allreduce(MPI_IN_PLACE, &stiffness, 1, MPI_DOUBLE, MPI_SUM, mesh_->comm());
  return {-most[0], -most[2], most[1] > 0 ? 0 : stiffness, most[1] > 0};
}

ContactMeasures ContactInterface::measures(Vec u) const {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const double eps = penalty();
  std::array<double, 7> sum{}; // force, length, energy, active, sliding
  std::array<double, 3> largest = {-infinity, 0,
                                   -infinity}; // minus smallest gap, pressure, minus smallest pressure
  visit(form_->nodes().displacement(u), Derivatives::first, [&](const Constraint& c) {
    largest[0] = std::max(largest[0], -c.distance());
    // Multipliers that hold g = 0 exactly store nothing.
    if (!semismooth()) sum[4] += c.weight * contact_potential(c.lambda, eps, c.gap);
    if (!c.active) return;
    const Tangential t = traction_to_keep(c);
    // A penalty keeps the traction's energy too; augmentations take it for a multiplier.
    if (settings_.enforce == Enforcement::penalty) sum[4] += c.weight * inner(t, t) / (2 * eps);
    std::array<double, 3> force{};
    add_force(c, force);
    for (std::size_t k = 0; k < 3; ++k) sum[k] += force[k];
    sum[3] += c.weight * c.stretch;
    sum[5] += 1;
    if (rubs(c) && slip_->trial[at(dim_) * at(c.index) + tangents()] == 2) sum[6] += 1;
    largest[1] = std::max(largest[1], c.pressure / c.stretch);
    largest[2] = std::max(largest[2], -c.pressure / c.stretch);
  });
  MPI_Allreduce(MPI_IN_PLACE, sum.data(), 7, MPI_DOUBLE, MPI_SUM, mesh_->comm());
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
  m.sliding = static_cast<int>(sum[6]);
  if (traction_ != nullptr) m.dissipated = thick * totals_->trial.back();
  m.gap_min = std::isinf(largest[0]) ? std::numeric_limits<double>::quiet_NaN() : -largest[0];
  m.pressure_max = largest[1];
  m.pressure_min = m.active > 0 ? -largest[2] : 0;
  m.work = thick * totals_->trial[at(dim_)];
  return m;
}

ContactFields ContactInterface::nodal_fields(Vec u) const {
  // By nodes, sums over the constraints that face something: of weights times values, in rows of dim numbers.
  enum Sum { of_all, of_state, of_traction, of_slip, sums };
  enum Column { weighed_pressure, weighed_gap }; // of_all; of_state: weights of what presses, of what slides
  const ContactNodes& nodes = form_->nodes();
  const auto d = at(dim_);
  std::array<std::vector<double>, sums> sum;
  std::vector<double> faces(d * nodes.global.size(), 0.0); // weight
  for (std::vector<double>& values : sum) values.assign(faces.size(), 0.0);
  const auto directions = traction_ != nullptr ? Derivatives::first : Derivatives::none;
  visit(nodes.displacement(u), directions, [&](const Constraint& c) {
    std::array<double, 3> t{}, s{};
    bool slides = c.active;
    if (rubs(c)) {
      const double* kept = &slip_->trial[d * at(c.index)];
      slides = kept[d - 1] == 2;
      const Tangential traction = this->traction(c).value;
      const std::size_t n = d * c.node.size();
      for (std::size_t a = 0; a < tangents(); ++a) {
        // What a translation of the secondary side slips: the direction times the covered part.
        std::array<double, 3> along{};
        for (std::size_t i = 0; i < d * c.share.size(); ++i) along[i % d] += c.slip_gradient[n * a + i];
        const double square = along[0] * along[0] + along[1] * along[1] + along[2] * along[2];
        for (std::size_t k = 0; k < d; ++k) {
          t[k] -= traction[a] / c.stretch * along[k];
          if (square > 0) s[k] += kept[a] / square * along[k];
        }
      }
    }
    for (std::size_t a = 0; a < c.share.size(); ++a) {
      const double weight = c.weight * c.share[a];
      const std::size_t i = d * at(c.node[a]);
      faces[i] += weight;
      sum[of_all][i + weighed_pressure] += weight * c.pressure / c.stretch;
      sum[of_all][i + weighed_gap] += weight * c.distance();
      if (c.active) sum[of_state][i] += weight;
      if (slides) sum[of_state][i + 1] += weight;
      for (std::size_t k = 0; k < d; ++k) {
        sum[of_traction][i + k] += weight * t[k];
        sum[of_slip][i + k] += c.active ? weight * s[k] : 0;
      }
    }
  });
  const Handle<Vec> global = layout_->make_global();
  const auto gather = [&](std::vector<double>& values) {
    std::vector<double> local = layout_->make_local();
    check(VecSet(global, 0));
    nodes.exchange.add(values, global);
    layout_->to_local(global, local);
    values = std::move(local);
  };
  gather(faces);
  for (std::vector<double>& values : sum) gather(values);
  const auto count = at(mesh_->node_count());
  ContactFields fields;
  fields.pressure.assign(count, 0.0);
  fields.gap.assign(count, std::numeric_limits<double>::quiet_NaN());
  fields.status.assign(count, 0.0);
  fields.traction.assign(3 * count, 0.0);
  fields.slip.assign(3 * count, 0.0);
  for (std::size_t node = 0; node < count; ++node) {
    const std::size_t i = d * node;
    const double area = form_->nodal_area()[node], pressing = sum[of_state][i];
    if (area > 0) fields.pressure[node] = sum[of_all][i + weighed_pressure] / area;
    if (faces[i] > 0) fields.gap[node] = sum[of_all][i + weighed_gap] / faces[i];
    if (!(pressing > 0)) continue;
    fields.status[node] = sum[of_state][i + 1] > pressing / 2 ? 2 : 1;
    for (std::size_t k = 0; k < d; ++k) {
      if (area > 0) fields.traction[3 * node + k] = sum[of_traction][i + k] / area;
      fields.slip[3 * node + k] = sum[of_slip][i + k] / pressing;
    }
  }
  return fields;
}

} // namespace impact
