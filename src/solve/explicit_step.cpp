#include <algorithm>
#include <cmath>
#include <impact/petsc/field_solver.hpp>
#include <impact/petsc/log.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/surface_load.hpp>
#include <impact/solve/explicit_step.hpp>
#include <impact/time/types.hpp>

namespace impact {

namespace {

constexpr double longest_interval = 64; // steps
// While the stable step is longer than the one in use by less than this, the one in use stays. Steps that
// follow every swing of the cells gain energy: 2 % in 1e5 steps of a spinning plate whose step changed by 2 %
// with its strain of 4 %; steps of one length gain none.
constexpr double hold = 1.1;
constexpr double rounding = 1e-3; // by which the bound of a stable step may miss it

PetscInt first_of(Vec x) {
  PetscInt first = 0;
  check(VecGetOwnershipRange(x, &first, nullptr));
  return first;
}

} // namespace

ExplicitStep::ExplicitStep(TS ts, MotionProblem& motion, StateTable& state, Erosion* erosion,
                           const ExplicitScenario& settings)
    : ts_(ts), motion_(motion), state_(state), erosion_(erosion), settings_(settings),
      row_(state.add({"stable_step", Support::global, components}, components)),
      impulses_(motion.discretisation().displacement) {
  const FieldLayout& layout = motion.discretisation().displacement;
  forces_.internal = layout.make_global();
  forces_.contact = layout.make_global();
  if (!motion.contacts().empty()) stiffness_ = layout.make_global();
  for (const ContactInterface& contact : motion.contacts()) {
    of_contacts_.push_back({layout.make_global(), {}});
    if (!contact.by_impulse() || work_.half) continue;
    for (Handle<Vec>* made : {&work_.inverse_mass, &work_.half, &work_.free}) *made = layout.make_global();
  }
}

void ExplicitStep::start(Vec u, Vec v) {
  const Discretisation& d = motion_.discretisation();
  const std::vector<double> place = d.local_of(u), speed = d.local_of(v);
  double dt = motion_.stable_step(u, place, 1, {});
  std::vector<double> before = place; // bulk viscosity knows the velocity by a step
  for (std::size_t i = 0; i < before.size(); ++i) before[i] -= dt * speed[i];
  dt = motion_.stable_step(u, before, dt, settings_.bulk);
  row_.committed = row_.trial = {dt, 1, 1, 0};
  set_penalties(dt);
}

// The stiffness of a penalty eps that acts on the area A of a node of mass m is felt as 2 eps A/m at most:
// the gap is a mean over either side, and the square of a difference at most twice the sum of the squares.
std::vector<double> ExplicitStep::contact_loads(const ContactInterface& contact) {
  const Discretisation& d = motion_.discretisation();
  const std::vector<double> X(d.mesh.coordinates().begin(), d.mesh.coordinates().end()),
      mass = d.local_of(motion_.lumped_mass());
  std::vector<double> area = d.displacement.make_local();
  const auto unit = [&](const double*, double* value) { std::fill_n(value, d.dim(), 1.0); };
  for (const std::string& side : {contact.settings().secondary, contact.settings().primary})
    if (!ContactSettings::rigid_name(side)) add_dead_traction(contact.facets(side), d.frame, X, unit, area);
  add_up(d.displacement, area);
  for (std::size_t i = 0; i < area.size(); ++i) area[i] *= 2 / mass[i];
  return area;
}

// With dt = s dt_e, dt_e the stable step of the cells, dt^2 (4/dt_e^2 + w^2) <= 4 leaves w^2 = 4 (1 -
// s^2)/dt^2 to the contacts. Shorter steps than 0.8 dt_e resolve that one better, and do not make it stiffer.
void ExplicitStep::set_penalties(double longest_of_cells) {
  ContactSet& contacts = motion_.contacts();
  const MPI_Comm comm = motion_.discretisation().mesh.comm();
  std::vector<std::vector<double>> loads;
  std::vector<double> total = motion_.discretisation().displacement.make_local();
  for (const ContactInterface& contact : contacts) {
    loads.push_back(contact_loads(contact));
    if (contact.settings().automatic_penalty && !contact.by_impulse())
      for (std::size_t i = 0; i < total.size(); ++i) total[i] += loads.back()[i];
  }
  const double s = std::clamp(settings_.cfl, 0.8, 0.9), dt = s * longest_of_cells,
               budget = 4 * (1 - s * s) / (dt * dt);
  std::size_t c = 0;
  for (ContactInterface& contact : contacts) {
    double largest = 0;
    for (std::size_t i = 0; i < total.size(); ++i)
      if (loads[c][i] > 0) largest = std::max(largest, total[i]);
    largest = max_over_ranks(comm, largest);
    if (contact.settings().automatic_penalty && !contact.by_impulse() && largest > 0)
      contact.set_penalty(budget / largest);
    ++c;
  }
}

double ExplicitStep::contact_frequency() {
  std::vector<double> sum = motion_.discretisation().displacement.make_local();
  for (const ContactInterface& contact : motion_.contacts()) {
    if (contact.by_impulse()) continue;
    const std::vector<double> loads = contact_loads(contact);
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += contact.penalty() * loads[i];
  }
  double largest = 0;
  for (const double value : sum) largest = std::max(largest, value);
  return max_over_ranks(motion_.discretisation().mesh.comm(), largest);
}

double ExplicitStep::longest() {
  if (contact_frequency_ < 0) contact_frequency_ = contact_frequency();
  const double dt = row_.committed[of_cells],
               cells = settings_.cfl * dt * (settings_.cfl == 1 ? 1 + rounding : 1);
  const double square = std::max(contact_frequency_, row_.committed[of_penalties]);
  if (square == 0) return cells;
  return std::min(cells, 2 / std::sqrt(4 / (dt * dt) + square));
}

std::string ExplicitStep::text(double asked) {
  const double dt = row_.committed[of_cells], most = longest();
  std::string text =
      text_of("central differences: the stable step of the cells is %.4g, with contacts %.4g", dt,
              contact_frequency_ > 0 ? 2 / std::sqrt(4 / (dt * dt) + contact_frequency_) : dt);
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
  const std::vector<double> u = d.local_of(now.u), v = d.local_of(now.v);
  const std::vector<double> before = now.a ? d.local_of(now.a) : std::vector<double>();
  const std::vector<double>& rate = state_.row("prescribed_velocity").committed;
  std::vector<double> goal = u, speed = rate;
  if (now.a) boundary.set_exact_velocity(now.t - now.dt, now.t, rate, speed);
  boundary.set_displacement(now.t, now.t + now.dt, u, speed, goal);
  double* values = nullptr;
  const PetscInt start = first_of(a);
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
  divide_by_mass({0, Get(TSGetTimeStep)(ts_), u, v, nullptr}, a);
}

void ExplicitStep::expose(Vec u) {
  std::vector<char> eroded = motion_.discretisation().eroded.cell;
  eroded.resize(at(motion_.discretisation().mesh.cell_count()), 0);
  for (ContactInterface& contact : motion_.contacts()) contact.expose(eroded, u);
  contact_frequency_ = -1;
}

void ExplicitStep::find_contact_forces(Vec u, bool by_impulse) {
  auto known = of_contacts_.begin();
  for (const ContactInterface& contact : motion_.contacts()) {
    if (contact.by_impulse() == by_impulse) {
      check(VecSet(known->residual, 0));
      known->part = contact.add_residual(u, 1, known->residual, by_impulse ? nullptr : stiffness_.get());
      check(VecAXPY(forces_.contact, -1, known->residual));
    }
    ++known;
  }
}

void ExplicitStep::find_stiffness_bound() {
  if (of_contacts_.empty()) return;
  check(VecPointwiseDivide(stiffness_, stiffness_, motion_.lumped_mass()));
  check(VecMax(stiffness_, nullptr, &row_.trial[of_penalties]));
}

// 0 at prescribed dofs.
void ExplicitStep::invert_mass() {
  const Discretisation& d = motion_.discretisation();
  check(VecCopy(motion_.lumped_mass(), work_.inverse_mass));
  check(VecReciprocal(work_.inverse_mass));
  const PetscInt start = first_of(work_.inverse_mass);
  double* values = nullptr;
  check(VecGetArray(work_.inverse_mass, &values));
  for (const FixedDof& fixed : motion_.boundary().fixed()) {
    const int node = fixed.dof / d.dim();
    if (d.mesh.owned(node)) values[d.mesh.global_node()[at(node)] * d.dim() + fixed.component - start] = 0;
  }
  check(VecRestoreArray(work_.inverse_mass, &values));
}

void ExplicitStep::follow_damage(Vec u, const std::vector<double>& phi) {
  const FieldLayout& layout = motion_.discretisation().displacement;
  if (!work_.change) work_.change = layout.make_global();
  if (!work_.inverse_mass) work_.inverse_mass = layout.make_global();
  motion_.damage_force(u, phi, work_.change);
  check(VecAXPY(forces_.internal, 1, work_.change));
  invert_mass();
  check(VecPointwiseMult(work_.change, work_.change, work_.inverse_mass));
  check(VecAXPY(new_acceleration(ts_), -1, work_.change));
}

// What moves freely in the next step, if it is as long as this one, is pushed where it would meet something.
void ExplicitStep::add_impulses(Vec u, const Rates& now, Vec a) {
  if (!work_.half) return;
  invert_mass();
  check(VecWAXPY(work_.half, now.dt / 2, now.a, now.v));
  check(VecWAXPY(work_.free, now.dt, a, work_.half));
  impulses_.find(motion_.contacts(), {u, work_.half, work_.free, work_.inverse_mass, now.t, now.dt});
  check(VecSet(work_.half, 0));
  check(VecAXPY(work_.half, -1, forces_.contact));
  find_contact_forces(u, true);
  check(VecAXPY(work_.half, 1, forces_.contact)); // of impulses alone
  check(VecPointwiseMult(work_.half, work_.half, work_.inverse_mass));
  check(VecAXPY(a, 1, work_.half));
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
  motion_.update_contact(u);
  if (!motion_.advance(u, sums, heat, forces_.internal)) return false;
  if (erosion_ != nullptr && erosion_->remove(motion_.inverted()) &&
      !motion_.advance(u, sums, heat, forces_.internal))
    return false;
  motion_.loads(u, forces_.external);
  const Rates rates{step.t, step.dt, u, start_velocity(ts_), acceleration(ts_)};
  check(VecSet(forces_.contact, 0));
  if (stiffness_) check(VecSet(stiffness_, 0));
  find_contact_forces(u, false);
  find_stiffness_bound();
  divide_by_mass(rates, new_acceleration(ts_));
  add_impulses(u, rates, new_acceleration(ts_));
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
