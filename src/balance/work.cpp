#include <algorithm>
#include <impact/balance/work.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/ranks.hpp>

namespace impact {

namespace {

// Sum over the owned dofs of a . b; both local arrays [node][dim].
double dot(const Mesh& mesh, const std::vector<double>& a, const std::vector<double>& b) {
  const auto components = at(mesh.dim());
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (mesh.owned(static_cast<int>(i / components))) sum += a[i] * b[i];
  return sum_over_ranks(mesh.comm(), sum);
}

StateRow& add_force(StateTable& state, const Discretisation& d, const char* name) {
  return state.add({name, Support::vertex, d.dim()}, d.node_values(d.dim()));
}

// [node][dim], zero where the unilateral stress does not act apart.
std::vector<double> unilateral_of(const Discretisation& d, const ForceParts& parts) {
  return parts.unilateral ? d.local_of(parts.unilateral) : d.displacement.make_local();
}

} // namespace

ForceBook::ForceBook(MotionProblem& motion, StateTable& state, bool inertia)
    : motion_(motion), u_(state.row("u")), v_(state.row("v")), a_(state.row("a")), inertia_(inertia),
      internal_(add_force(state, motion.discretisation(), "force_internal")),
      external_(add_force(state, motion.discretisation(), "force_external")),
      contact_(add_force(state, motion.discretisation(), "force_contact")),
      inertia_force_(add_force(state, motion.discretisation(), "force_inertia")),
      left_(add_force(state, motion.discretisation(), "force_left")),
      a_before_(add_force(state, motion.discretisation(), "a_before")),
      closing_(state.find("closing_carried") ? &add_force(state, motion.discretisation(), "force_closing")
                                             : nullptr),
      damping_(motion.foundations().damps()
                   ? &add_force(state, motion.discretisation(), "bc_foundations_damping")
                   : nullptr),
      a_new_(internal_.trial.size()) {}

double ForceBook::mean_work(const std::vector<double>& du, const StateRow& row) const {
  std::vector<double> mean(row.trial.size());
  for (std::size_t i = 0; i < mean.size(); ++i) mean[i] = 0.5 * (row.committed[i] + row.trial[i]);
  return dot(motion_.discretisation().mesh, du, mean);
}

bool ForceBook::in_rigid_body(std::size_t dof) const {
  const std::vector<int>& body = motion_.rigid().body_of_node();
  return !body.empty() && body[dof / at(motion_.discretisation().dim())] >= 0;
}

// Of rigid bodies central differences keep what ExplicitBodies says, not what the nodes would.
double ForceBook::kept_by_nodes_of_bodies(double dt, Vec a, Vec Ma) const {
  const Discretisation& d = motion_.discretisation();
  if (motion_.rigid().empty()) return 0;
  const std::vector<double> rate = d.local_of(a);
  std::vector<double> inertia = d.local_of(Ma);
  for (std::size_t i = 0; i < inertia.size(); ++i)
    if (!in_rigid_body(i)) inertia[i] = 0;
  return dt * dt / 8 * dot(d.mesh, rate, inertia);
}

double ForceBook::start(const Integrator& integrator, double dt, Vec u, Vec a, bool moving) {
  const Discretisation& d = motion_.discretisation();
  ForceParts parts;
  motion_.parts(u, parts);
  if (integrator.is_explicit()) { // bulk viscosity acts from the start on
    MotionProblem::Increments unused;
    motion_.advance(u, unused, {}, parts.internal);
  }
  d.displacement.to_local(parts.internal, internal_.trial);
  d.displacement.to_local(parts.external, external_.trial);
  if (damping_) d.displacement.to_local(parts.damping, damping_->trial);
  sprung_ = sum_over_ranks(d.mesh.comm(), parts.sprung);
  for (StateRow* row : {&inertia_force_, &left_}) std::ranges::fill(row->trial, 0);
  d.displacement.to_local(a, a_before_.trial);
  double kept = 0;
  if (inertia_) {
    // M a_0 balances these forces on the free dofs, contact apart.
    const Handle<Vec> Ma = d.displacement.make_global();
    motion_.mass_multiply(a, Ma);
    d.displacement.to_local(Ma, inertia_force_.trial);
    if (integrator.is_explicit()) {
      kept = integrator.kept_at_start(dt, a, Ma) + kept_by_nodes_of_bodies(dt, a, Ma);
    } else {
      motion_.rigid().place(u);
      const Handle<Vec> free = free_part(a);
      motion_.mass_multiply(free, Ma);
      kept = integrator.kept_at_start(dt, free, Ma);
    }
  }
  const std::vector<double> loads = external_.trial, unilateral = unilateral_of(d, parts);
  const std::vector<double>& touch = contact_.trial = contact_.committed;
  reactions_ = internal_.trial;
  for (std::size_t i = 0; i < loads.size(); ++i) {
    if (closing_) closing_->trial[i] = -unilateral[i];
    // Statics knows no load that is put on at once: what the start lacks to balance grows in the first step,
    // but where inertia balanced it, which no load takes over.
    const double balancing = inertia_force_.trial[i] + internal_.trial[i] + unilateral[i] - touch[i];
    if (motion_.boundary().fixed_mask()[i] || (!inertia_ && !moving))
      external_.trial[i] = balancing;
    else if (!inertia_)
      left_.trial[i] = balancing - loads[i];
    reactions_[i] += unilateral[i] - loads[i] - touch[i];
  }
  return kept;
}

void ForceBook::resume() { reactions_ = motion_.discretisation().displacement.make_local(); }

// dt times the forces S of the projection strike the bodies at the start of a step. M (v_start - v_n) is that
// on free dofs; what it is beside that comes from supports, and in rigid bodies also from what keeps them so.
ShockWork ForceBook::find_shock(const StepRecord& step) const {
  const Discretisation& d = motion_.discretisation();
  ShockWork shock;
  double size = 0;
  check(VecNorm(step.contact_shock, NORM_INFINITY, &size));
  if (size == 0) return shock;
  const Handle<Vec> u_n = d.global_of(u_.committed), v_n = d.global_of(v_.committed),
                    mean = d.displacement.make_global(), jump = d.displacement.make_global(),
                    beside = d.displacement.make_global();
  check(VecWAXPY(jump, -1, v_n, step.start_velocity));
  motion_.mass_multiply(jump, beside);
  check(VecAXPY(beside, -step.dt, step.contact_shock));
  check(VecWAXPY(mean, 0.5, jump, v_n));
  const std::vector<double> speed = d.local_of(mean), force = d.local_of(step.contact_shock);
  std::vector<double> other = d.local_of(beside), held = other;
  for (std::size_t i = 0; i < speed.size(); ++i) {
    if (!motion_.boundary().fixed_mask()[i]) held[i] = 0;
    if (!in_rigid_body(i)) other[i] = 0;
  }
  const double of_bodies = d.thickness * step.dt * motion_.rigid().strike_power(step.contact_shock, u_n, v_n);
  shock.contact = d.thickness * step.dt * dot(d.mesh, speed, force);
  shock.supports = d.thickness * dot(d.mesh, speed, held) + of_bodies;
  shock.rigid = d.thickness * dot(d.mesh, speed, other) - of_bodies;
  return shock;
}

// Of rigid bodies what the scheme has a free hand in.
Handle<Vec> ForceBook::free_part(Vec of) const {
  Handle<Vec> free = motion_.discretisation().displacement.make_global();
  check(VecCopy(of, free));
  motion_.rigid().keep_free_rates(free);
  return free;
}

// The scheme's own energy; the inertia that the step balanced goes into its row.
IntegratorEnergy ForceBook::find_integrator_energy(const StepRecord& step, Vec u, Vec v, Vec a, double kept) {
  const Discretisation& d = motion_.discretisation();
  const Integrator& weights = step.integrator;
  const Handle<Vec> du = d.global_of(u_.committed), a_n = d.global_of(a_.committed),
                    change = d.global_of(a_before_.committed), lag = d.displacement.make_global();
  const auto times_mass = [&](Vec of) {
    Handle<Vec> force = d.displacement.make_global();
    motion_.mass_multiply(of, force);
    return force;
  };
  check(VecAYPX(du, -1, u));
  check(VecAYPX(change, -1, a_n));
  a_before_.trial = a_.committed;
  Handle<Vec> Ma_n = times_mass(a_n), Ma = times_mass(a), mean = d.displacement.make_global();
  d.displacement.to_global(inertia_force_.committed, lag);
  check(VecAXPY(lag, -1, Ma_n));
  check(VecCopy(Ma, mean));
  check(VecAXPBY(mean, 1 - weights.alpha_m, weights.alpha_m, Ma_n));
  d.displacement.to_local(mean, inertia_force_.trial);
  RigidBodies& rigid = motion_.rigid();
  rigid.place(u);
  for (const Vec of : {du.get(), a_n.get(), change.get()}) rigid.keep_free_rates(of);
  const Handle<Vec> free_start = free_part(step.start_velocity), free_v = free_part(v), free_a = free_part(a);
  if (!rigid.empty()) {
    Ma_n = times_mass(a_n);
    Ma = times_mass(free_a);
  }
  return weights.energy({.dt = step.dt,
                         .du = du,
                         .v_start = free_start,
                         .v = free_v,
                         .a_n = a_n,
                         .a = free_a,
                         .change = change,
                         .Ma_n = Ma_n,
                         .Ma = Ma,
                         .Mchange = times_mass(change),
                         .lag = lag,
                         .kept = kept});
}

// Forces at t_{n+1} as the motion solve used them: frozen phi, committed history. `corrected` becomes what
// acts on displacement and velocity as one force over the step: the share of a_c, twice beta of it in M a_c.
// That is `over_step`, and of rigid bodies what keeps them rigid, and the reactions there.
void ForceBook::take_over_forces(const StepRecord& step, std::vector<double>& corrected) {
  const Discretisation& d = motion_.discretisation();
  d.displacement.to_local(step.forces->internal, internal_.trial);
  d.displacement.to_local(step.forces->external, external_.trial);
  d.displacement.to_local(step.contact_at_end, contact_.trial);
  d.displacement.to_local(step.left, left_.trial);
  for (std::vector<double>* none : {&over_step_, &hidden_}) none->resize(corrected.size());
  if (!inertia_) return;
  Handle<Vec> force = d.displacement.make_global();
  motion_.mass_multiply(step.contact_acceleration, force);
  const Integrator& weights = step.integrator;
  check(VecScale(force, step.stabilised || step.unilateral ? 2 * weights.beta : weights.alpha_m));
  d.displacement.to_local(force, corrected);
  if (step.closing_at_end) d.displacement.to_local(step.closing_at_end, closing_->trial);
  if (!step.stabilised && !step.unilateral) return;
  d.displacement.to_local(step.over_step, over_step_);
  d.displacement.to_local(step.hidden, hidden_);
}

// Finds the reactions of rigid bodies, and returns their work; v without what data then put into it.
double ForceBook::book_bodies(const StepRecord& step, Vec u, Vec v) {
  if (motion_.rigid().empty()) return 0;
  const FieldLayout& layout = motion_.discretisation().displacement;
  std::vector<double> acting = contact_.trial;
  for (std::size_t i = 0; i < acting.size(); ++i)
    acting[i] = inertia_ ? over_step_[i] + (inertia_force_.committed[i] + inertia_force_.trial[i]) / 2
                         : acting[i] + external_.trial[i];
  const Handle<Vec> missing = layout.make_global(), others = layout.make_global(),
                    told = layout.make_global();
  double of_data = 0;
  if (inertia_) {
    const Handle<Vec> gained = layout.make_global();
    check(VecWAXPY(gained, -1, step.start_velocity, v));
    motion_.mass_multiply(gained, missing);
    check(VecScale(missing, 1 / step.dt));
    motion_.mass_multiply(step.told_velocity, told);
    of_data = Get(VecDot)(told, v) + Get(VecDot)(told, step.told_velocity) / 2;
    check(VecScale(told, 1 / step.dt));
  }
  layout.to_global(acting, others);
  check(VecAXPY(missing, -1, others));
  return of_data + motion_.rigid().book_reactions(u, missing, told);
}

// The support supplies what closes the balance on held dofs: a mean of both ends, and of what acts over the
// step a part that does so too, which is returned. What `hidden_` has is no part of the reaction.
std::vector<double> ForceBook::close_balance(const StepRecord& step, const std::vector<double>& corrected) {
  const bool parted = step.stabilised || step.unilateral;
  std::vector<double> over_step(corrected.size(), 0.0);
  reactions_.resize(over_step.size());
  for (std::size_t i = 0; i < over_step.size(); ++i) {
    const double closing = step.closing_at_end ? closing_->trial[i] : 0,
                 of_step = corrected[i] - over_step_[i],
                 at_end = inertia_force_.trial[i] + internal_.trial[i] - external_.trial[i] -
                          contact_.trial[i] - closing;
    reactions_[i] = at_end + of_step + hidden_[i];
    if (in_rigid_body(i)) {
      left_.trial[i] = 0; // holds resultants
      if (!inertia_) inertia_force_.trial[i] = external_.trial[i] + contact_.trial[i];
    }
    if (!motion_.boundary().fixed_mask()[i]) continue;
    external_.trial[i] += parted ? at_end : reactions_[i];
    if (parted) over_step[i] = of_step;
  }
  return over_step;
}

double ForceBook::kept(double dt, Vec a) {
  const Discretisation& d = motion_.discretisation();
  mass_ = d.local_of(motion_.lumped_mass());
  const std::vector<double> rate = d.local_of(a);
  double sum = 0;
  for (std::size_t i = 0; i < rate.size(); ++i)
    if (d.mesh.owned(static_cast<int>(i / at(d.dim()))) && !in_rigid_body(i))
      sum += rate[i] * mass_[i] * rate[i];
  return -dt * dt / 8 * sum_over_ranks(d.mesh.comm(), sum);
}

// N1 and N2 with beta = 0: loss = -dt^2/8 (a.Ma - a_n.Ma_n), kept = -dt^2/8 a.Ma.
StepWork ForceBook::book_explicit(const StepRecord& step, Vec a) {
  const Discretisation& d = motion_.discretisation();
  const FieldLayout& layout = d.displacement;
  layout.owned_to_local(step.forces->internal, internal_.trial);
  layout.owned_to_local(step.forces->external, external_.trial);
  layout.owned_to_local(step.forces->contact, contact_.trial);
  layout.owned_to_local(a, a_new_);
  if (damping_) layout.owned_to_local(step.forces->damping, damping_->trial);
  if (mass_.empty()) mass_ = d.local_of(motion_.lumped_mass());
  const std::vector<double>& u = motion_.last_displacement();
  reactions_.resize(u.size());
  double sums[8] = {0, 0, 0, 0, 0, 0, 0, step.forces->sprung};
  const std::vector<char>& fixed = motion_.boundary().fixed_mask();
  const auto dim = at(d.dim());
  for (int node = 0; node < d.mesh.node_count(); ++node) {
    if (!d.mesh.owned(node)) continue;
    const bool rigid = in_rigid_body(dim * at(node)); // whose inertia is not that of the nodes
    for (std::size_t i = dim * at(node); i < dim * at(node + 1); ++i) {
      const double du = u[i] - u_.committed[i], a_n = a_.committed[i];
      inertia_force_.trial[i] = mass_[i] * a_new_[i];
      reactions_[i] = inertia_force_.trial[i] + internal_.trial[i] - external_.trial[i] - contact_.trial[i];
      if (fixed[i]) external_.trial[i] += reactions_[i];
      sums[1] += du * (external_.committed[i] + external_.trial[i]);
      sums[2] += du * (contact_.committed[i] + contact_.trial[i]);
      if (damping_) sums[6] += du * (damping_->committed[i] + damping_->trial[i]);
      if (rigid) continue;
      sums[0] += du * (internal_.committed[i] + internal_.trial[i]);
      sums[3] += a_new_[i] * inertia_force_.trial[i];
      sums[4] += a_n * mass_[i] * a_n;
    }
  }
  for (const ContactInterface& contact : motion_.contacts())
    sums[5] += contact.constraints().taken_by_jumps();
  motion_.tally().sum(sums);
  motion_.tally().reduce();
  const double factor = -step.dt * step.dt / 8;
  StepWork work;
  work.internal = sums[0] / 2;
  work.external = sums[1] / 2;
  work.contact = sums[2] / 2;
  work.jumps = sums[5];
  work.damping = sums[6] / 2;
  work.sprung = sums[7];
  work.rigid = step.bodies.supports;
  work.integrator.loss = factor * (sums[3] - sums[4]) + step.bodies.loss;
  work.integrator.kept = factor * sums[3] + step.bodies.kept;
  work.integrator.exchange = step.bodies.exchange;
  return work;
}

StepWork ForceBook::book(const StepRecord& step, Vec u, Vec v, Vec a, double kept) {
  const Discretisation& d = motion_.discretisation();
  StepWork work;
  motion_.tally().reduce();
  const Handle<Vec> by_forces = d.displacement.make_global(); // the velocity
  if (inertia_) {
    check(VecWAXPY(by_forces, -1, step.told_velocity, v));
    work.integrator = find_integrator_energy(step, u, by_forces, a, kept);
    work.shock = find_shock(step);
  }
  std::vector<double> corrected = d.displacement.make_local();
  take_over_forces(step, corrected);
  work.rigid = book_bodies(step, u, by_forces);
  // m tau- of broken points acts over the step as a whole, like the stabilised contact.
  const std::vector<double> unilateral = unilateral_of(d, *step.forces);
  const std::vector<double> over_step = close_balance(step, corrected);
  std::vector<double> du = d.local_of(u);
  for (std::size_t i = 0; i < du.size(); ++i) du[i] -= u_.committed[i];
  work.internal = mean_work(du, internal_);
  work.external = mean_work(du, external_);
  work.over_step = dot(d.mesh, du, over_step);
  work.contact = mean_work(du, contact_);
  work.unilateral = dot(d.mesh, du, unilateral);
  double more = 0; // of what acts over the step than of its mean (S4)
  if (step.closing_at_end) more -= work.unilateral + mean_work(du, *closing_);
  if (step.stabilised) {
    const double mean = std::exchange(work.contact, dot(d.mesh, du, d.local_of(step.contact_force)));
    more += work.contact - mean;
  }
  if (!step.integrator.moves_by_mean_velocity()) {
    work.integrator.loss += more;
    work.integrator.exchange += more;
  }
  work.left = mean_work(du, left_);
  if (damping_) {
    d.displacement.to_local(step.forces->damping, damping_->trial);
    work.damping = mean_work(du, *damping_);
  }
  if (!motion_.foundations().empty()) work.sprung = sum_over_ranks(d.mesh.comm(), step.forces->sprung);
  if (!inertia_) work.inertia = mean_work(du, inertia_force_);
  return work;
}

} // namespace impact
