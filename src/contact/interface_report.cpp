#include <algorithm>
#include <cmath>
#include <impact/contact/interface.hpp>
#include <impact/kernel/contact_pair.hpp>
#include <impact/kernel/frame.hpp>
#include <impact/math/index.hpp>
#include <impact/math/vector3.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/ranks.hpp>
#include <limits>

/// What a ContactInterface tells of a solution: energies of a step for the ledger, history columns, output
/// fields, where heat passes.
namespace impact {

namespace {

struct Rubbing {
  std::array<double, 3> t{}, s{}; // traction on the secondary side, per current area; slip
  bool slides = false;
};

Rubbing rubbing_at(const Constraint& c, const Friction& friction, std::size_t d) {
  Rubbing rubbing;
  rubbing.slides = c.active;
  if (!friction.rubs(c)) return rubbing;
  const double* kept = friction.slip(c);
  rubbing.slides = friction.state(c) == Friction::slides;
  const Tangential traction = friction.shown(c);
  const std::size_t n = d * c.node.size();
  for (std::size_t a = 0; a < d - 1; ++a) {
    // What a translation of the secondary side slips: the direction times the covered part.
    std::array<double, 3> along{};
    for (std::size_t i = 0; i < d * c.share.size(); ++i) along[i % d] += c.slip_gradient[n * a + i];
    const double square = along[0] * along[0] + along[1] * along[1] + along[2] * along[2];
    for (std::size_t k = 0; k < d; ++k) {
      rubbing.t[k] -= traction[a] / c.stretch * along[k];
      if (square > 0) rubbing.s[k] += kept[a] / square * along[k];
    }
  }
  return rubbing;
}

} // namespace

double ContactInterface::thickness() const {
  return is_flat(environment_.frame) ? environment_.thickness : 1;
}

// The force on the secondary side.
void ContactInterface::add_force(const Constraint& c, const Tangential& traction, Vector& force) const {
  const std::size_t d = constraints_->dim(), n = c.gradient.size();
  const auto add = [&](double times, const double* gradient) {
    for (std::size_t node = 0; node < c.share.size(); ++node)
      add_components(d, times, gradient + d * node, force.data());
  };
  add(c.weight * c.pressure, c.gradient.data());
  for (std::size_t a = 0; traction != Tangential{} && a < constraints_->tangents(); ++a)
    add(-(c.weight * traction[a]), &c.slip_gradient[n * a]);
}

ContactInterface::Vector ContactInterface::total_force(Vec u) const {
  Vector force{};
  const auto visitor = [&](const Constraint& c) {
    if (c.active) add_force(c, friction_.rubs(c) ? friction_.traction(c).value : Tangential{}, force);
  };
  constraints_->visit(u, Derivatives::first, visitor, constraints_->pressing());
  sum_over_ranks(mesh_->comm(), force);
  return of_the_end(force);
}

ContactInterface::Vector ContactInterface::of_the_end(Vector force) const {
  if (constraints_->works_exactly()) // what the trapezoidal rule makes the mean of
    for (std::size_t k = 0; k < constraints_->dim(); ++k)
      force[k] = 2 * force[k] - totals(totals_->committed).force[k];
  return force;
}

void ContactInterface::keep_shock(Vec w) {
  shock_ = total_force(w);
  for (double& component : shock_) component /= 2;
}

// Of the springs of normal and tangential penalties.
double ContactInterface::spring_energy(double gap, const Tangential& traction) const {
  const double eps = method().eps();
  return contact_potential(0, eps, gap) + inner(traction, traction) / (2 * eps);
}

// A penalty keeps the traction's energy too; augmentations take it for a multiplier.
void ContactInterface::add_energy(const Constraint& c, double& energy) const {
  energy += c.weight * method().potential(c);
  if (!c.active || method().has_multipliers()) return;
  const Tangential t = friction_.traction_to_keep(c);
  energy += c.weight * inner(t, t) / (2 * method().eps());
}

void ContactInterface::add_step(const Constraint& c, ContactSums& sums) const {
  add_energy(c, sums.energy);
  friction_.add_heat(c, sums.heat);
  if (c.works_exactly())
    sums.held += c.weight * spring_energy(c.start_gap, friction_.acts() ? friction_.held(c) : Tangential{});
  if (constraints_->conserving())
    sums.spring += c.weight * spring_energy(c.gap, friction_.traction_to_keep(c));
}

ContactStep ContactInterface::step(Vec u) const {
  ContactSums sum = end_.value_or(ContactSums{});
  if (!end_) {
    constraints_->visit(
        u, Derivatives::none, [&](const Constraint& c) { add_step(c, sum); }, ending());
    sum_over_ranks(mesh_->comm(), sum.numbers());
  }
  const double thick = thickness();
  const Totals before = totals(totals_->committed);
  ContactStep step;
  step.energy = thick * sum.energy;
  step.friction_loss = thick * sum.heat;
  if (constraints_->works_exactly()) step.released = thick * (*before.spring - sum.held);
  const Vector moved = pose().moved;
  if (moved == Vector{}) return step; // at rest, or no rigid body: no force is asked for
  const Vector force = end_ ? of_the_end(sum.force) : total_force(u);
  for (std::size_t k = 0; k < constraints_->dim(); ++k) {
    step.obstacle_work += thick * moved[k] * (stabilised() ? force[k] : (before.force[k] + force[k]) / 2);
    step.obstacle_shock += thick * moved[k] * shock_[k];
  }
  return step;
}

std::vector<HeatPath> ContactInterface::heat_paths(Vec u) const {
  std::vector<double> conductance(constraints_->count(), 0.0),
      friction(conductance); // of an area, of a place
  const ContactValues values = nodes().displacement(u);
  // What touches without pressure has one by rounding alone.
  const double touching = settings_.conductance_exponent > 0      ? -HUGE_VAL
                          : std::isnan(settings_.conductance_gap) ? 1e-6 * constraints_->mean_length()
                                                                  : settings_.conductance_gap;
  constraints_->visit(values, Derivatives::none, [&](const Constraint& c) {
    friction_.add_heat(c, friction[at(c.index)]);
    const double pressure = c.active ? std::max(c.pressure, 0.0) : 0.0;
    if (pressure > 0 || c.distance() <= touching)
      conductance[at(c.index)] = c.stretch * settings_.conductance_at(pressure / c.stretch);
  });
  std::vector<HeatPath> paths;
  constraints_->form().visit_meetings(constraints_->place_of_gradients(values), [&](const Meeting& meeting) {
    const std::size_t i = at(meeting.index);
    if (conductance[i] == 0 && friction[i] == 0) return;
    paths.push_back({meeting.area * conductance[i],
                     friction[i],
                     meeting.secondary,
                     {meeting.node.begin(), meeting.node.end()},
                     {meeting.share.begin(), meeting.share.end()}});
  });
  return paths;
}

bool ContactInterface::bears() const {
  double largest = 0;
  for (const double force : force_->committed) largest = std::max(largest, std::abs(force));
  return max_over_ranks(mesh_->comm(), largest) > 0;
}

bool ContactInterface::rests_on_penalty() const { return bears() && !rows_.press_anywhere(mesh_->comm()); }

double ContactInterface::held_by_multipliers(Vec u) const {
  double energy = 0;
  constraints_->visit(u, Derivatives::none, [&](const Constraint& c) {
    if (c.active) energy += c.weight * c.lambda * c.lambda / (2 * method().eps());
  });
  return sum_over_ranks(mesh_->comm(), energy);
}

ContactReach ContactInterface::reach(Vec u) const {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const double alike = 1e-6 * constraints_->mean_length();
  const std::vector<double> values = nodes().displacement(u);
  const auto dim = at(mesh_->dim());
  std::array<double, 3> most = {-infinity, 0, -infinity}; // minus gap, whether it presses, minus distance
  struct Place {
    double gap, area;
    Vector3 opens;
  };
  std::vector<Place> places;
  constraints_->visit(values, Derivatives::first, [&](const Constraint& c) {
    most[0] = std::max(most[0], -c.distance());
    if (c.active) most[1] = 1;
    Place place{c.distance(), c.weight, {}};
    for (std::size_t i = 0; i < dim * c.share.size(); ++i)
      place.opens[i % dim] += c.weight * c.gap_gradient()[i];
    places.push_back(place);
  });
  if (most[0] == -infinity) most[2] = -search().nearest_nodes(values);
  max_over_ranks(mesh_->comm(), most);
  std::array<double, 5> sum{}; // area that faces something, that touches first, way
  for (const auto& [gap, area, opens] : places) {
    sum[0] += area;
    if (gap < std::max(0.0, -most[0]) + alike) sum[1] += area;
    if (gap < alike - most[0])
      for (std::size_t k = 0; k < 3; ++k) sum[2 + k] += opens[k];
  }
  sum_over_ranks(mesh_->comm(), sum);
  constexpr double flat = 0.25;
  const double touches = sum[1] > flat * sum[0] ? sum[1] : 0;
  return {-most[0], -most[2], touches, touches * method().eps(), {sum[2], sum[3], sum[4]}, most[1] > 0};
}

ContactMeasures ContactInterface::measures(Vec u) const {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  // Sums and largest values over the ranks, each by its name.
  struct Sum {
    Vector force{};
    double length = 0, energy = 0, active = 0, sliding = 0;
  } sum;
  struct Largest {
    double overlap = -infinity, pressure = 0, minus_pressure = -infinity;
  } largest;
  constraints_->visit(u, Derivatives::first, [&](const Constraint& c) {
    largest.overlap = std::max(largest.overlap, -c.distance());
    add_energy(c, sum.energy);
    if (!c.active) return;
    const bool rubs = friction_.rubs(c);
    Vector force{};
    add_force(c, rubs ? friction_.traction(c).value : Tangential{}, force);
    for (std::size_t k = 0; k < 3; ++k) sum.force[k] += force[k];
    sum.length += c.weight * c.cover * c.stretch;
    sum.active += 1;
    if (rubs && friction_.state(c) == Friction::slides) sum.sliding += 1;
    largest.pressure = std::max(largest.pressure, c.pressure / c.stretch);
    largest.minus_pressure = std::max(largest.minus_pressure, -c.pressure / c.stretch);
  });
  MPI_Allreduce(MPI_IN_PLACE, &sum, sizeof sum / sizeof(double), MPI_DOUBLE, MPI_SUM, mesh_->comm());
  MPI_Allreduce(MPI_IN_PLACE, &largest, sizeof largest / sizeof(double), MPI_DOUBLE, MPI_MAX, mesh_->comm());
  const double thick = thickness();
  const Totals total = totals(totals_->trial);
  ContactMeasures m;
  for (std::size_t k = 0; k < constraints_->dim(); ++k) {
    m.force[k] = thick * (friction_.changed() ? total.force[k] : sum.force[k]);
    m.impulse[k] = thick * total.impulse[k];
  }
  m.length = sum.length;
  m.energy = thick * sum.energy;
  m.active = static_cast<int>(sum.active);
  m.sliding = static_cast<int>(sum.sliding);
  if (friction_.acts()) m.dissipated = thick * *total.heat;
  m.gap_min = std::isinf(largest.overlap) ? std::numeric_limits<double>::quiet_NaN() : -largest.overlap;
  m.pressure_max = largest.pressure;
  m.pressure_min = m.active > 0 ? -largest.minus_pressure : 0;
  m.work = thick * *total.work;
  return m;
}

ContactFields ContactInterface::nodal_fields(Vec u, ContactFields fields) const {
  // By nodes, sums over the constraints that face something: of weights times values, in rows of dim numbers.
  enum Sum { of_all, of_state, of_traction, of_slip, sums };
  enum Column { weighed_pressure, weighed_gap }; // of_all; of_state: weights of what presses, of what slides
  const ContactNodes& nodes = this->nodes();
  const std::size_t d = constraints_->dim();
  std::array<std::vector<double>, sums> sum;
  std::vector<double> faces(d * nodes.global.size(), 0.0); // weight
  for (std::vector<double>& values : sum) values.assign(faces.size(), 0.0);
  const auto directions = friction_.acts() ? Derivatives::first : Derivatives::none;
  constraints_->visit(nodes.displacement(u), directions, [&](const Constraint& c) {
    const Rubbing rubbing = rubbing_at(c, friction_, d);
    for (std::size_t a = 0; a < c.share.size(); ++a) {
      const double weight = c.weight * c.nodal_parts()[a];
      const std::size_t i = d * at(c.node[a]);
      faces[i] += weight;
      sum[of_all][i + weighed_pressure] += weight * c.pressure / c.stretch;
      sum[of_all][i + weighed_gap] += weight * c.distance();
      if (c.active) sum[of_state][i] += weight;
      if (rubbing.slides) sum[of_state][i + 1] += weight;
      for (std::size_t k = 0; k < d; ++k) {
        sum[of_traction][i + k] += weight * rubbing.t[k];
        sum[of_slip][i + k] += c.active ? weight * rubbing.s[k] : 0;
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
  for (std::vector<double>* field : {&fields.pressure, &fields.status}) field->resize(count, 0.0);
  for (std::vector<double>* field : {&fields.traction, &fields.slip}) field->resize(3 * count, 0.0);
  fields.gap.resize(count, std::numeric_limits<double>::quiet_NaN());
  const auto raise = [](double& value, double to) { value = std::max(value, to); };
  const auto set = [](double& value, double to) {
    if (to != 0) value = to;
  };
  for (std::size_t node = 0; node < count; ++node) {
    const std::size_t i = d * node;
    const double area = constraints_->form().nodal_area()[node], pressing = sum[of_state][i];
    if (area > 0) raise(fields.pressure[node], sum[of_all][i + weighed_pressure] / area);
    if (faces[i] > 0) fields.gap[node] = std::fmin(fields.gap[node], sum[of_all][i + weighed_gap] / faces[i]);
    if (!(pressing > 0)) continue;
    raise(fields.status[node], sum[of_state][i + 1] > pressing / 2 ? 2 : 1);
    for (std::size_t k = 0; k < d; ++k) {
      if (area > 0) set(fields.traction[3 * node + k], sum[of_traction][i + k] / area);
      set(fields.slip[3 * node + k], sum[of_slip][i + k] / pressing);
    }
  }
  return fields;
}

} // namespace impact
