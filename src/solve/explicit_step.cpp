#include <algorithm>
#include <cmath>
#include <impact/petsc/entries.hpp>
#include <impact/petsc/field_solver.hpp>
#include <impact/petsc/log.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/solve/explicit_step.hpp>
#include <impact/time/types.hpp>
#include <optional>

namespace impact {

namespace {

constexpr double longest_interval = 64; // steps
// While the stable step is longer than the one in use by less than this, the one in use stays. Steps that
// follow every swing of the cells gain energy: 2 % in 1e5 steps of a spinning plate whose step changed by 2 %
// with its strain of 4 %; steps of one length gain none.
constexpr double hold = 1.1;
constexpr double rounding = 1e-3;  // by which the bound of a stable step may miss it
constexpr double collapsed = 0.01; // part of the first stable step
// Of the step that penalties allow, where nothing deforms: a body turns round on one in 60 steps, and its
// energy is kept to 3e-4. Beside cells the penalties are softer than these.
constexpr double of_rigid_impacts = 0.05;

PetscInt first_of(Vec x) {
  PetscInt first = 0;
  check(VecGetOwnershipRange(x, &first, nullptr));
  return first;
}

} // namespace

ExplicitStep::ExplicitStep(TS ts, MotionProblem& motion, StateTable& state, Erosion* erosion,
                           const ExplicitScenario& settings)
    : ts_(ts), motion_(motion), state_(state), erosion_(erosion), settings_(settings),
      row_(state.add({"stable_step", Support::global, components}, components)), contacts_(motion),
      bodies_(motion, state) {
  const FieldLayout& layout = motion.discretisation().displacement;
  for (Handle<Vec>* force : {&forces_.internal, &forces_.contact}) *force = layout.make_global();
}

void ExplicitStep::start(Vec u, Vec v) {
  const Discretisation& d = motion_.discretisation();
  const std::vector<double> place = d.local_of(u), speed = d.local_of(v);
  double dt = motion_.stable_step(u, {place, 1, {}}, cells_of_step());
  std::vector<double> before = place; // bulk viscosity knows the velocity by a step
  for (std::size_t i = 0; i < before.size(); ++i) before[i] -= dt * speed[i];
  if (settings_.scaled_step > 0) scale_mass(u, before, dt);
  dt = motion_.stable_step(u, {before, dt, settings_.bulk}, cells_of_step());
  row_.committed = row_.trial = {dt, 1, 1, 0, contacts_.closing(speed)};
  first_step_ = dt;
  for (ContactInterface& contact : motion_.contacts()) contact.constraints().begin_jumps();
  bodies_.start(u, v);
  bodies_.resume();
  contacts_.set_penalties(std::isfinite(dt) ? dt : stable_without_contact() / settings_.cfl, settings_.cfl,
                          speed);
  contacts_.report_multipliers(u);
  weigh_foundations();
}

void ExplicitStep::weigh_foundations() {
  of_foundations_ = motion_.foundations().frequency(motion_.lumped_mass());
}

// Springs of contacts swing too: what strikes is met in time where steps are no longer than beside the
// stiffest cell.
CellsOfStep ExplicitStep::cells_of_step() const {
  return contacts_.penalties().empty() ? CellsOfStep::together : CellsOfStep::stiffest;
}

void ExplicitStep::scale_mass(Vec u, const std::vector<double>& before, double dt) {
  StateRow& factors = state_.row("mass_factor");
  const MassScaling& scaling =
      motion_.scale_mass(u, {before, dt, settings_.bulk}, cells_of_step(), settings_.scaled_step, factors);
  if (scaling.share > settings_.scaling_limit)
    throw UserError(ExitCode::usage,
                    text_of("-ts_mass_scaling_dt %.4g: %d cells need %.4g times the mass of all bodies in "
                            "addition, more than -ts_mass_scaling_limit %.4g; take a shorter one (the "
                            "stable step without is %.4g), or allow more",
                            settings_.scaled_step, scaling.cells, scaling.share, settings_.scaling_limit,
                            dt));
}

void ExplicitStep::resume() {
  first_step_ = row_.committed[of_cells];
  if (settings_.scaled_step > 0) motion_.use_mass(state_.row("mass_factor"));
  weigh_foundations();
  bodies_.resume();
}

void ExplicitStep::tell_of_collapse(double dt) {
  if (dt >= collapsed * first_step_) return;
  first_step_ = 0;
  const bool spreads = settings_.bulk.acts();
  check(PetscPrintf(
      motion_.discretisation().mesh.comm(),
      "impact: the stable step has fallen to %.3g, less than a hundredth of the first one, by the cell at "
      "%s: %s"
      "let cells leave that deform so far (-material_<id>_erosion with _erosion_strain, _J, _stretch or "
      "_step; where damage acts only those leave by the last three that are broken by _erosion_phi at "
      "_erosion_points of their points)\n",
      dt, motion_.slowest_cell().c_str(),
      spreads ? ""
              : "shocks want a bulk viscosity (-ts_bulk_viscosity_linear 0.06 -ts_bulk_viscosity_quadratic "
                "1.2); "));
}

// Where nothing deforms the steps are those that were asked for, or what penalties allow.
double ExplicitStep::stable_without_contact() const {
  const double dt = Get(TSGetTimeStep)(ts_);
  return dt > 0 ? dt : HUGE_VAL;
}

double ExplicitStep::longest() {
  const double dt = row_.committed[of_cells],
               cells = settings_.cfl * dt * (settings_.cfl == 1 ? 1 + rounding : 1);
  const double square = std::max(contacts_.frequency(), row_.committed[of_penalties]) + of_foundations_;
  const double closing = row_.committed[of_closing],
               approach = closing > 0 ? ExplicitContact::part_of_depth / closing : HUGE_VAL;
  const double steps = std::min({cells, bodies_.longest(), approach});
  if (square == 0) return steps;
  const double with_contacts = 2 / std::sqrt(4 / (dt * dt) + square);
  return std::min(steps,
                  std::isfinite(dt) ? with_contacts : of_rigid_impacts * settings_.cfl * with_contacts);
}

std::string ExplicitStep::text(double asked) {
  const double dt = row_.committed[of_cells], most = longest(),
               square = contacts_.frequency() + of_foundations_;
  std::string text = text_of(
      "central differences: the stable step of the cells is %.4g, with contacts%s %.4g", dt,
      of_foundations_ > 0 ? " and foundations" : "", square > 0 ? 2 / std::sqrt(4 / (dt * dt) + square) : dt);
  if (const std::string penalties = contacts_.penalties(); !penalties.empty())
    text += "; penalty of " + penalties;
  if (settings_.scaled_step > 0) {
    const MassScaling& scaling = motion_.mass_scaling();
    text += text_of("; mass scaling adds %.4g kg to %d cells, %.3g of the mass of all bodies", scaling.added,
                    scaling.cells, scaling.share);
  }
  if (asked > most) text += text_of("; -ts_dt %.4g is longer: steps are at most %.4g", asked, most);
  if (const std::string cell = motion_.slowest_cell(); !cell.empty())
    text += "; the shortest is that of the cell at " + cell;
  return text;
}

void ExplicitStep::divide_by_mass(const Rates& now, Vec a) {
  check(VecAXPBYPCZ(a, 1, -1, 0, forces_.external, forces_.internal));
  check(VecAXPY(a, 1, forces_.contact));
  check(VecPointwiseDivide(a, a, motion_.lumped_mass()));
  prescribe(now, a);
  motion_.foundations().damp({now.dt, now.v, now.a}, motion_.lumped_mass(), motion_.boundary().fixed_mask(),
                             a, forces_.external, forces_.damping);
}

// Prescribed dofs take the acceleration by which the next step, if it is as long as this one, ends on their
// data.
void ExplicitStep::prescribe(const Rates& now, Vec a) {
  const Discretisation& d = motion_.discretisation();
  const BoundaryData& boundary = motion_.boundary();
  const int dim = d.dim();
  if (boundary.fixed().empty()) return;
  const std::vector<double>& rate = state_.row("prescribed_velocity").committed;
  const PetscInt start = first_of(a);
  const Entries u(now.u), v(now.v);
  std::optional<Entries> before;
  if (now.a) before.emplace(now.a);
  WritableEntries values(a);
  for (const FixedDof& fixed : boundary.fixed()) {
    const int node = fixed.dof / dim;
    if (!d.mesh.owned(node)) continue;
    const PetscInt i = d.mesh.global_node()[at(node)] * dim + fixed.component - start;
    double speed = rate[at(fixed.dof)];
    if (before) speed = boundary.exact_velocity(fixed, now.t - now.dt, now.t, speed);
    const double goal = boundary.prescribed(fixed, now.t, now.t + now.dt, u[i], speed);
    const double needed = (goal - u[i] - now.dt * v[i]) / (now.dt * now.dt);
    // v is that of the last step, to which half of both accelerations is still to be added
    values[i] = before ? needed - (*before)[i] / 2 : 2 * needed;
  }
}

void ExplicitStep::start_acceleration(Vec u, Vec v, Vec contact, Vec a) {
  MotionProblem::Increments unused;
  motion_.advance(u, unused, {}, forces_.internal);
  motion_.loads(u, forces_.external);
  motion_.add_foundations(forces_, false);
  if (contact)
    check(VecCopy(contact, forces_.contact));
  else
    check(VecSet(forces_.contact, 0));
  const double t = motion_.step().t, dt = Get(TSGetTimeStep)(ts_); // t > 0 after steps of another scheme
  divide_by_mass({t, dt, u, v, nullptr}, a);
  bodies_.start_forces(t, dt, {{{forces_.external, 1}}}, a);
}

// 0 at prescribed dofs and on rigid bodies.
void ExplicitStep::invert_mass() {
  const Discretisation& d = motion_.discretisation();
  if (!work_.inverse_mass) work_.inverse_mass = d.displacement.make_global();
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
  bodies_.leave_out(work_.inverse_mass);
}

void ExplicitStep::follow_damage(Vec u, const std::vector<double>& phi) {
  const FieldLayout& layout = motion_.discretisation().displacement;
  if (!work_.change) work_.change = layout.make_global();
  motion_.damage_force(u, phi, work_.change);
  check(VecAXPY(forces_.internal, 1, work_.change));
  invert_mass();
  check(VecPointwiseMult(work_.change, work_.change, work_.inverse_mass));
  check(VecAXPY(new_acceleration(ts_), -1, work_.change));
}

bool ExplicitStep::take(Vec u, MotionProblem::Increments& sums, const HeatRows& heat) {
  const MotionStep& step = motion_.step();
  bodies_.move(step.dt, u);
  for (ContactInterface& contact : motion_.contacts())
    contact.set_longest_step(std::max(1.0, 0.8 * row_.committed[of_cells] / step.dt));
  motion_.contacts().look(u, motion_.tally());
  if (!motion_.advance(u, sums, heat, forces_.internal)) return false;
  if (erosion_ != nullptr && erosion_->remove(motion_.inverted()) &&
      !motion_.advance(u, sums, heat, forces_.internal))
    return false;
  motion_.update_contact(u);
  row_.trial[of_closing] = contacts_.closing_in(step.dt);
  motion_.loads(u, forces_.external);
  motion_.add_foundations(forces_, false);
  const Rates rates{step.t, step.dt, u, start_velocity(ts_), acceleration(ts_)};
  const Vec a = new_acceleration(ts_);
  if (!motion_.contacts().empty()) {
    if (!work_.u_n) work_.u_n = motion_.discretisation().displacement.make_global();
    motion_.discretisation().displacement.to_global(*step.u_n, work_.u_n);
  }
  contacts_.find_forces(work_.u_n, u, forces_.contact);
  divide_by_mass(rates, a);
  const std::array<ExplicitBodies::Force, 2> on_bodies = {{{forces_.external, 1}, {forces_.contact, 1}}};
  row_.trial[of_penalties] = bodies_.push(step.t, on_bodies, contacts_.on_bodies(), a);
  if (contacts_.by_impulse()) {
    invert_mass();
    contacts_.add_impulses({rates.t, rates.dt, work_.u_n, u, rates.v, rates.a}, work_.inverse_mass, bodies_,
                           forces_.contact, a);
    bodies_.push(step.t, on_bodies, contacts_.on_bodies(), a);
  }
  row_.trial[left] = row_.committed[left] - 1;
  if (row_.trial[left] > 0) return true;
  const double before = row_.committed[of_cells];
  const double of_those_left = motion_.stable_step(u, {*step.u_n, step.dt, settings_.bulk}, cells_of_step()),
               now = std::isfinite(of_those_left) ? of_those_left : before; // where no cell is left
  tell_of_collapse(now);
  const double often = row_.committed[interval];
  row_.trial[of_cells] = now < before || now > hold * before ? now : before;
  row_.trial[interval] = now < 0.98 * before    ? std::max(1.0, std::floor(often / 2))
                         : now > 0.995 * before ? std::min(longest_interval, 2 * often)
                                                : often;
  row_.trial[left] = row_.trial[interval];
  return true;
}

void ExplicitStep::accept() {
  row_.trial[of_penalties] = std::max(row_.trial[of_penalties], contacts_.frequency_at_work());
  contacts_.tell_of_depth();
}

} // namespace impact
