#include <algorithm>
#include <cmath>
#include <impact/petsc/field_solver.hpp>
#include <impact/petsc/log.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/surface_load.hpp>
#include <impact/solve/explicit_step.hpp>
#include <impact/time/types.hpp>
#include <numbers>

namespace impact {

namespace {

constexpr double longest_interval = 64; // steps
// While the stable step is longer than the one in use by less than this, the one in use stays. Steps that
// follow every swing of the cells gain energy: 2 % in 1e5 steps of a spinning plate whose step changed by 2 %
// with its strain of 4 %; steps of one length gain none.
constexpr double hold = 1.1;
constexpr double rounding = 1e-3; // by which the bound of a stable step may miss it

} // namespace

ExplicitStep::ExplicitStep(TS ts, MotionProblem& motion, StateTable& state, const ExplicitScenario& settings)
    : ts_(ts), motion_(motion), state_(state), settings_(settings),
      row_(state.add({"stable_step", Support::global, components}, components)), bodies_(motion, state),
      stiffness_of_bodies_(motion.rigid().bodies().size()) {
  const FieldLayout& layout = motion.discretisation().displacement;
  forces_.internal = layout.make_global();
  forces_.contact = layout.make_global();
  if (!motion.contacts().empty()) stiffness_ = layout.make_global();
  for (std::size_t c = 0; c < motion.contacts().size(); ++c)
    of_contacts_.push_back({layout.make_global(), {}});
}

void ExplicitStep::start(Vec u, Vec v) {
  const Discretisation& d = motion_.discretisation();
  const std::vector<double> place = d.local_of(u), speed = d.local_of(v);
  double dt = motion_.stable_step(u, place, 1, {});
  std::vector<double> before = place; // bulk viscosity knows the velocity by a step
  for (std::size_t i = 0; i < before.size(); ++i) before[i] -= dt * speed[i];
  if (settings_.scaled_step > 0) scale_mass(u, before, dt);
  dt = motion_.stable_step(u, before, dt, settings_.bulk);
  row_.committed = row_.trial = {dt, 1, 1, 0};
  bodies_.start(u, v);
  bodies_.resume();
  set_penalties(std::isfinite(dt) ? dt : stable_without_contact() / settings_.cfl);
}

void ExplicitStep::scale_mass(Vec u, const std::vector<double>& before, double dt) {
  StateRow& factors = state_.row("mass_factor");
  const MassScaling& scaling =
      motion_.scale_mass(u, before, dt, settings_.bulk, settings_.scaled_step, factors);
  if (scaling.share > settings_.scaling_limit)
    throw UserError(ExitCode::usage,
                    text_of("-ts_mass_scaling_dt %.4g: %d cells need %.4g times the mass of all bodies in "
                            "addition, more than -ts_mass_scaling_limit %.4g; take a shorter one (the "
                            "stable step without is %.4g), or allow more",
                            settings_.scaled_step, scaling.cells, scaling.share, settings_.scaling_limit,
                            dt));
}

void ExplicitStep::resume() {
  if (settings_.scaled_step > 0) motion_.use_mass(state_.row("mass_factor"));
  bodies_.resume();
}

// Where nothing deforms the steps are those that were asked for, or what penalties allow.
double ExplicitStep::stable_without_contact() const {
  const double dt = Get(TSGetTimeStep)(ts_);
  return dt > 0 ? dt : HUGE_VAL;
}

void ExplicitStep::ContactLoads::add(const ContactLoads& other, double factor) {
  for (std::size_t i = 0; i < nodes.size(); ++i) nodes[i] += factor * other.nodes[i];
  for (std::size_t b = 0; b < bodies.size(); ++b) bodies[b] += factor * other.bodies[b];
}

double ExplicitStep::ContactLoads::largest() const {
  double most = 0;
  for (const double load : nodes) most = std::max(most, load);
  for (const double load : bodies) most = std::max(most, load);
  return most;
}

ExplicitStep::ContactLoads ExplicitStep::no_loads() const {
  return {motion_.discretisation().displacement.make_local(),
          std::vector<double>(motion_.rigid().bodies().size())};
}

// The stiffness of a penalty eps that acts on the area A of a node of mass m is felt as 2 eps A/m at most:
// the gap is a mean over either side, and the square of a difference at most twice the sum of the squares.
// Nodes of a rigid body give way as a whole: |v + w x r|^2 <= (1/m + r.r/J) (m v.v + w . J w), J the least
// moment of inertia.
ExplicitStep::ContactLoads ExplicitStep::contact_loads(const ContactInterface& contact) {
  const Discretisation& d = motion_.discretisation();
  const std::vector<double> X(d.mesh.coordinates().begin(), d.mesh.coordinates().end()),
      mass = d.local_of(motion_.lumped_mass());
  ContactLoads loads = no_loads();
  const auto unit = [&](const double*, double* value) { std::fill_n(value, d.dim(), 1.0); };
  const auto add_side = [&](const std::string& side) {
    std::vector<double> area = d.displacement.make_local();
    if (ContactSettings::rigid_name(side)) return area;
    add_dead_traction(d.mesh.facets(side), d.frame, X, unit, area);
    add_up(d.displacement, area);
    for (std::size_t i = 0; i < area.size(); ++i) loads.nodes[i] += 2 * area[i] / mass[i];
    return area;
  };
  const std::vector<double> secondary = add_side(contact.settings().secondary);
  std::vector<double> area = secondary;
  if (contact.settings().primary != contact.settings().secondary) {
    const std::vector<double> primary = add_side(contact.settings().primary);
    for (std::size_t i = 0; i < area.size(); ++i) area[i] += primary[i];
  }
  if (motion_.rigid().empty()) return loads;
  const int dim = d.dim();
  for (std::size_t i = 0; i < area.size(); ++i) {
    const int node = static_cast<int>(i) / dim, body = motion_.rigid().body_of_node()[at(node)];
    if (body < 0) continue;
    loads.nodes[i] = 0;
    if (static_cast<int>(i) % dim == 0 && d.mesh.owned(node))
      loads.bodies[at(body)] += 2 * area[i] * motion_.rigid().give(at(body), &X[i]);
  }
  add_load_on_obstacle(contact, secondary, loads.bodies);
  sum_over_ranks(d.mesh.comm(), loads.bodies);
  return loads;
}

// All of the surface may press on a plane, on a round body as much as its shadow. Pressure there has no arm
// about the centre; friction has the radius.
void ExplicitStep::add_load_on_obstacle(const ContactInterface& contact, const std::vector<double>& area,
                                        std::vector<double>& of_bodies) const {
  const ContactSettings& settings = contact.settings();
  const Discretisation& d = motion_.discretisation();
  if (settings.carrier.empty()) return;
  const auto& bodies = motion_.rigid().bodies();
  const auto found = std::find_if(bodies.begin(), bodies.end(),
                                  [&](const RigidBody& body) { return body.name == settings.carrier; });
  if (found == bodies.end()) return;
  const auto b = static_cast<std::size_t>(found - bodies.begin());
  const int dim = d.dim();
  const bool plane = settings.primary == "plane";
  double whole = 0, load = 0;
  for (int node = 0; node < d.mesh.node_count(); ++node) {
    if (!d.mesh.owned(node)) continue;
    const double mine = area[at(dim * node)];
    whole += mine;
    load += 2 * mine * motion_.rigid().give(b, &d.mesh.coordinates()[at(dim * node)]);
  }
  if (plane) {
    of_bodies[b] += load;
    return;
  }
  Vector3 rim = found->centre;
  if (settings.friction > 0) rim[0] += settings.radius;
  const double shadow = d.frame == Frame::solid && settings.primary == "rigid_sphere"
                            ? std::numbers::pi * settings.radius * settings.radius
                        : d.frame == Frame::plane_strain || d.frame == Frame::plane_stress
                            ? 2 * settings.radius
                            : HUGE_VAL;
  int ranks = 0;
  MPI_Comm_size(d.mesh.comm(), &ranks);
  of_bodies[b] += 2 * std::min(whole, shadow / ranks) * motion_.rigid().give(b, rim.data());
}

// With dt = s dt_e, dt_e the stable step of the cells, dt^2 (4/dt_e^2 + w^2) <= 4 leaves w^2 = 4 (1 -
// s^2)/dt^2 to the contacts. Shorter steps than 0.8 dt_e resolve that one better, and do not make it stiffer.
void ExplicitStep::set_penalties(double longest_of_cells) {
  ContactSet& contacts = motion_.contacts();
  const MPI_Comm comm = motion_.discretisation().mesh.comm();
  std::vector<ContactLoads> loads;
  ContactLoads total = no_loads();
  for (const ContactInterface& contact : contacts) {
    loads.push_back(contact_loads(contact));
    if (contact.settings().automatic_penalty) total.add(loads.back(), 1);
  }
  const double s = std::clamp(settings_.cfl, 0.8, 0.9), dt = s * longest_of_cells,
               budget = 4 * (1 - s * s) / (dt * dt);
  std::size_t c = 0;
  for (ContactInterface& contact : contacts) {
    double largest = 0;
    for (std::size_t i = 0; i < total.nodes.size(); ++i)
      if (loads[c].nodes[i] > 0) largest = std::max(largest, total.nodes[i]);
    for (std::size_t b = 0; b < total.bodies.size(); ++b)
      if (loads[c].bodies[b] > 0) largest = std::max(largest, total.bodies[b]);
    largest = max_over_ranks(comm, largest);
    if (contact.settings().automatic_penalty && largest > 0) contact.set_penalty(budget / largest);
    ++c;
  }
}

double ExplicitStep::contact_frequency() {
  ContactLoads sum = no_loads();
  for (const ContactInterface& contact : motion_.contacts())
    sum.add(contact_loads(contact), contact.penalty());
  return max_over_ranks(motion_.discretisation().mesh.comm(), sum.largest());
}

double ExplicitStep::longest() {
  if (contact_frequency_ < 0) contact_frequency_ = contact_frequency();
  const double dt = row_.committed[of_cells],
               cells = settings_.cfl * dt * (settings_.cfl == 1 ? 1 + rounding : 1);
  const double square = std::max(contact_frequency_, row_.committed[of_penalties]);
  const double steps = std::min(cells, bodies_.longest());
  if (square == 0) return steps;
  const double with_contacts = 2 / std::sqrt(4 / (dt * dt) + square);
  return std::min(steps, std::isfinite(dt) ? with_contacts : settings_.cfl * with_contacts);
}

std::string ExplicitStep::text(double asked) {
  const double dt = row_.committed[of_cells], most = longest();
  std::string text =
      text_of("central differences: the stable step of the cells is %.4g, with contacts %.4g", dt,
              contact_frequency_ > 0 ? 2 / std::sqrt(4 / (dt * dt) + contact_frequency_) : dt);
  if (settings_.scaled_step > 0) {
    const MassScaling& scaling = motion_.mass_scaling();
    text += text_of("; mass scaling adds %.4g kg to %d cells, %.3g of the mass of all bodies", scaling.added,
                    scaling.cells, scaling.share);
  }
  if (asked > most) text += text_of("; -ts_dt %.4g is longer: steps are at most %.4g", asked, most);
  return text;
}

// Prescribed dofs take the acceleration by which the next step, if it is as long as this one, ends on their
// data.
void ExplicitStep::divide_by_mass(const Rates& now, Vec a) {
  const Discretisation& d = motion_.discretisation();
  const BoundaryData& boundary = motion_.boundary();
  const int dim = d.dim();
  check(VecAXPBYPCZ(a, 1, -1, 0, forces_.external, forces_.internal));
  check(VecAXPY(a, 1, forces_.contact));
  check(VecPointwiseDivide(a, a, motion_.lumped_mass()));
  if (boundary.fixed().empty()) return;
  auto& [u, v, before, goal, speed] = held_; // of the nodes that are owned
  for (std::vector<double>* values : {&u, &v, &before}) values->resize(d.node_values(dim));
  d.displacement.owned_to_local(now.u, u);
  d.displacement.owned_to_local(now.v, v);
  if (now.a) d.displacement.owned_to_local(now.a, before);
  const std::vector<double>& rate = state_.row("prescribed_velocity").committed;
  goal = u;
  speed = rate;
  if (now.a) boundary.set_exact_velocity(now.t - now.dt, now.t, rate, speed);
  boundary.set_displacement(now.t, now.t + now.dt, u, speed, goal);
  double* values = nullptr;
  const PetscInt start = [&] {
    PetscInt first = 0;
    check(VecGetOwnershipRange(a, &first, nullptr));
    return first;
  }();
  check(VecGetArray(a, &values));
  for (const FixedDof& fixed : boundary.fixed()) {
    const int node = fixed.dof / dim;
    if (!d.mesh.owned(node)) continue;
    const std::size_t i = at(fixed.dof);
    const double needed = (goal[i] - u[i] - now.dt * v[i]) / (now.dt * now.dt);
    // v is that of the last step, to which half of both accelerations is still to be added
    values[d.mesh.global_node()[at(node)] * dim + fixed.component - start] =
        now.a ? needed - before[i] / 2 : 2 * needed;
  }
  check(VecRestoreArray(a, &values));
}

void ExplicitStep::start_acceleration(Vec u, Vec v, Vec a) {
  MotionProblem::Increments unused;
  motion_.advance(u, unused, {}, forces_.internal);
  motion_.loads(u, forces_.external);
  check(VecSet(forces_.contact, 0));
  const double dt = Get(TSGetTimeStep)(ts_);
  divide_by_mass({0, dt, u, v, nullptr}, a);
  bodies_.start_forces(0, dt, {{{forces_.external, 1}}}, a);
}

void ExplicitStep::find_contact_forces(Vec u) {
  check(VecSet(forces_.contact, 0));
  if (of_contacts_.empty()) return;
  check(VecSet(stiffness_, 0));
  std::fill(stiffness_of_bodies_.begin(), stiffness_of_bodies_.end(), 0.0);
  auto known = of_contacts_.begin();
  for (const ContactInterface& contact : motion_.contacts()) {
    check(VecSet(known->residual, 0));
    known->part = contact.add_residual(u, 1, known->residual, stiffness_, &stiffness_of_bodies_);
    check(VecAXPY(forces_.contact, -1, known->residual));
    ++known;
  }
  check(VecPointwiseDivide(stiffness_, stiffness_, motion_.lumped_mass()));
  check(VecMax(stiffness_, nullptr, &row_.trial[of_penalties]));
}

void ExplicitStep::advance_contacts(Vec u_n, Vec u, double dt) {
  auto known = of_contacts_.begin();
  for (ContactInterface& contact : motion_.contacts()) {
    contact.advance(u_n, u, dt, known->residual, known->part);
    ++known;
  }
}

bool ExplicitStep::take(Vec u, MotionProblem::Increments& sums, const HeatRows& heat) {
  const MotionStep& step = motion_.step();
  bodies_.move(step.dt, u);
  motion_.update_contact(u);
  if (!motion_.advance(u, sums, heat, forces_.internal)) return false;
  motion_.loads(u, forces_.external);
  find_contact_forces(u);
  divide_by_mass({step.t, step.dt, u, start_velocity(ts_), acceleration(ts_)}, new_acceleration(ts_));
  const std::array<ExplicitBodies::Force, 2> on_bodies = {{{forces_.external, 1}, {forces_.contact, 1}}};
  row_.trial[of_penalties] = std::max(
      row_.trial[of_penalties], bodies_.push(step.t, on_bodies, stiffness_of_bodies_, new_acceleration(ts_)));
  row_.trial[left] = row_.committed[left] - 1;
  if (row_.trial[left] > 0) return true;
  const double before = row_.committed[of_cells];
  const double now = motion_.stable_step(u, *step.u_n, step.dt, settings_.bulk);
  const double often = row_.committed[interval];
  row_.trial[of_cells] = now < before || now > hold * before ? now : before;
  row_.trial[interval] = now < 0.98 * before    ? std::max(1.0, std::floor(often / 2))
                         : now > 0.995 * before ? std::min(longest_interval, 2 * often)
                                                : often;
  row_.trial[left] = row_.trial[interval];
  return true;
}

} // namespace impact
