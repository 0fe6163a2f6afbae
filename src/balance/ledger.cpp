#include <algorithm>
#include <cmath>
#include <impact/balance/ledger.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/field_solver.hpp>
#include <impact/petsc/log.hpp>

namespace impact {

namespace {

bool prescribes_damage(MotionProblem& motion) {
  const auto& conditions = motion.boundary().conditions();
  return motion.discretisation().has_damage() &&
         std::any_of(conditions.begin(), conditions.end(),
                     [](const auto& bc) { return bc.type == BcType::damage; });
}

StateRow& add_numbers(StateTable& state, const char* name, std::size_t count) {
  return state.add({name, Support::global, static_cast<int>(count)}, count);
}

} // namespace

Ledger::Ledger(MotionProblem& motion, StateTable& state, bool inertia, bool moves, LedgerChoice choice)
    : motion_(motion), state_(state), rows_(state), inertia_(inertia), moves_(moves),
      prescribes_damage_(prescribes_damage(motion)), choice_(choice),
      totals_(add_numbers(state, "ledger_totals", Total::count)),
      losses_(add_numbers(state, "ledger_materials",
                          motion.discretisation().materials.size() * static_cast<std::size_t>(losses))),
      erosion_(motion.discretisation().erodes() ? &state.row("erosion_totals") : nullptr),
      foundations_(add_numbers(state, "bc_foundations", FoundationSum::count)),
      forces_(motion, state, inertia), reactions_(motion, state) {
  energies_.of.resize(motion_.discretisation().materials.size());
  if (motion_.discretisation().has_heat())
    heat_.emplace(motion_, state, choice.heat ? choice.heat->contacts() : std::vector<std::string>());
}

void Ledger::measure(Vec u, Vec v, bool trial) {
  energies_ = find_energies(motion_.discretisation(), rows_, u, inertia_ ? v : nullptr, trial);
}

void Ledger::start(const Integrator& integrator, double dt, Vec u, Vec v, Vec a, double kept_by_bodies) {
  measure(u, v, false);
  for (const ContactStep& contact : motion_.contacts().step(u)) sum(contact_store) += contact.energy;
  for (const ContactInterface& contact : motion_.contacts())
    if (!inertia_ && contact.reach(u).gap < -1e-9 * contact.settings().search_radius) springs_apart_ = true;
  sum(start_energy) = stored();
  if (heat_) heat_->start(energies_.total.entropy);
  sum(scale) = std::abs(sum(start_energy));
  sum(kept) = motion_.discretisation().thickness * (forces_.start(integrator, dt, u, a) + kept_by_bodies);
  sum(kept_at_start) = sum(kept);
  foundations_.trial[FoundationSum::store] = motion_.discretisation().thickness * forces_.sprung();
  sum(start_energy) = stored();
  sum(kinetic) = energies_.total.kinetic;
  reactions_.find(forces_.reactions(), u, v);
}

void Ledger::resume(Vec u, Vec v) {
  forces_.resume();
  measure(u, v, false);
}

void Ledger::resume_with(const Integrator& integrator, double dt, Vec u, Vec v, Vec a) {
  measure(u, v, false);
  const double more = energies_.total.kinetic - sum(kinetic);
  sum(more > 0 ? start_energy : numerical) += std::abs(more);
  sum(kinetic) = energies_.total.kinetic;
  const double kept_now = motion_.discretisation().thickness * forces_.start(integrator, dt, u, a, true);
  sum(numerical) -= kept_now - sum(kept);
  sum(kept) = kept_now;
  // What the scheme before missed, as gaps that a static step closed, is not this one's.
  sum(start_energy) += balance_first_law() * energy_scale();
  reactions_.find(forces_.reactions(), u, v);
}

void Ledger::book(const StepRecord& step, Vec u, Vec v, Vec a, bool watched) {
  const Timed timed(Event::balances);
  const double w = motion_.discretisation().thickness;
  energies_before_ = energies_;
  DamageLosses by_damage;
  if (rows_.phi) {
    by_damage = find_damage_losses(motion_.discretisation(), rows_, step);
    by_damage.add_to(motion_.tally());
  }
  note_loads(step);
  const StepWork work = step.integrator.is_explicit() ? forces_.book_explicit(step, a)
                                                      : forces_.book(step, u, v, a, sum(kept) / w);
  const double work_internal = w * work.internal;
  const double work_external = w * work.external + w * work.over_step + w * work.rigid + work.shock.supports;
  const double work_contact = w * work.contact;
  const double work_unilateral = w * work.unilateral;
  const double work_left = w * work.left;
  if (watched) measure(u, v, true);
  const double kinetic_change = watched ? energies_.total.kinetic - sum(kinetic) : 0;
  if (watched) sum(kinetic) = energies_.total.kinetic;
  // Without inertia the arms of a rigid body's forces belong to the end of the step, and their work to no
  // one.
  const double of_arms = inertia_ ? 0 : w * work.rigid + w * work.inertia;
  sum(external) += work_external + book_foundations(work);
  book_contact(work, work_contact, step, u, watched);
  const double loss = w * work.integrator.loss, keeps = w * work.integrator.kept;
  sum(numerical) += loss - (keeps - sum(kept));
  sum(kept) = keeps;
  sum(exchange) += w * work.integrator.exchange;
  sum(unbalanced) += work_left;
  sum(identity) += kinetic_change + loss + work_internal + work_unilateral - work_external - work_contact -
                   work.shock.contact - work.shock.rigid - work_left + of_arms;
  for (std::size_t k = 0; erosion_ != nullptr && k < 3; ++k)
    erosion_->trial[ErosionTotals::momentum + k] +=
        step.dt / 2 * std::exchange(erosion_->trial[ErosionTotals::force + k], 0);
  book_points(step, by_damage, work_unilateral);
  if (choice_.coupling_error) find_coupling_error(step);
  if (heat_) heat_->book(step, w);
  if (!watched) return;
  book_scale(step.dt);
  reactions_.find(forces_.reactions(), u, v);
}

// Contact takes energy from bodies and obstacles that it neither keeps nor rubs into heat: the stabilised
// update closes gaps against the pressure of the step's end and strikes the bodies, as a plastic impact does,
// and so do the impulses of explicit steps; penalties of these lose springs (78''). In statics what overlaps
// at the start of the run springs apart in the first step, by an energy of that start; of gaps that close
// within a step the trapezoidal rule takes the pressure for one from its start on.
void Ledger::book_contact(const StepWork& work, double work_contact, const StepRecord& step, Vec u,
                          bool watched) {
  sum(contact_work) += work_contact;
  const ContactSet& all = motion_.contacts();
  const bool idle = std::none_of(all.begin(), all.end(), [](const auto& contact) {
    return contact.frictional() || contact.settings().rigid();
  });
  const bool strikes =
      step.stabilised || std::any_of(all.begin(), all.end(), [](const auto& c) { return c.by_impulse(); });
  if (!strikes) sum(contact_loss) += motion_.discretisation().thickness * work.jumps;
  if (!watched && idle && !strikes) return;
  const std::vector<ContactStep> contacts = all.step(u);
  double store = 0;
  for (const ContactStep& contact : contacts) store += contact.energy;
  double taken = -work_contact - work.shock.contact - work.shock.rigid - (store - sum(contact_store));
  for (const ContactStep& contact : contacts) {
    sum(external) += contact.obstacle_work + contact.obstacle_shock;
    sum(friction) += contact.friction_loss;
    sum(contact_loss) += contact.released;
    taken += contact.obstacle_work + contact.obstacle_shock - contact.friction_loss;
  }
  if (strikes) sum(contact_loss) += taken;
  // What augmented penalties hold at the start, as stiff as they happen to be, is no energy of the bodies.
  const double sprung = springs_apart_ && step.first ? std::min(taken, sum(contact_store)) : 0;
  sum(start_energy) -= sprung;
  if (!inertia_) sum(gap_work) += taken - sprung;
  sum(contact_store) = store;
}

void Ledger::note_loads(const StepRecord& step) {
  if (!moves_ || step.integrator.is_explicit() || step.counts.newton > 0) return;
  const PetscReal loads = Get(VecNorm)(step.forces->external, NORM_2), left = Get(VecNorm)(step.left, NORM_2);
  if (loads > 0 && left > 1e-3 * loads) ++unanswered_;
}

// Returns what springs stored and dashpots lost, which the bodies did not get from them. Those that a run has
// left out at a restart take what they stored along.
double Ledger::book_foundations(const StepWork& work) {
  const double w = motion_.discretisation().thickness, lost = -w * work.damping,
               before = std::exchange(foundations_.trial[FoundationSum::store], w * work.sprung);
  foundations_.trial[FoundationSum::loss] += lost;
  return lost + w * work.sprung - before;
}

void Ledger::book_points(const StepRecord& step, const DamageLosses& by_damage, double work_unilateral) {
  const double w = motion_.discretisation().thickness;
  if (step.unilateral) sum(closing) += work_unilateral - w * unilateral_energy(step.phi);
  const MotionProblem::Increments& increments = *step.increments;
  sum(viscous) += w * increments.viscous_dissipation;
  sum(plastic_dissipation) += w * increments.plastic_dissipation;
  sum(least) = std::min(sum(least), increments.least_dissipation);
  for (std::size_t m = 0; m < increments.viscous_part.size(); ++m) {
    lost_in(m, viscous_loss) += w * increments.viscous_part[m];
    lost_in(m, plastic_loss) += w * increments.plastic_part[m];
  }
  if (rows_.phi) book_damage(step, by_damage);
  sum(least) = std::min(sum(least), step.least_fatigue);
  for (std::size_t m = 0; m < step.fatigue_dissipation.size(); ++m) {
    lost_in(m, fatigue_part) += w * step.fatigue_dissipation[m];
    sum(fatigue_loss) += w * step.fatigue_dissipation[m];
  }
}

void Ledger::book_damage(const StepRecord& step, const DamageLosses& lost) {
  const double w = motion_.discretisation().thickness;
  sum(least) = std::min(sum(least), -lost.most_gained);
  for (std::size_t m = 0; m < lost.by_rate.size(); ++m) {
    const double by_rate = w * lost.by_rate[m], by_exchange = w * lost.by_exchange[m];
    sum(damage) += by_rate;
    sum(plastic_dissipation) += by_exchange;
    lost_in(m, damage_loss) += by_rate;
    lost_in(m, plastic_loss) += by_exchange;
  }
  const double work = w * step.prescribed_damage_work;
  sum(damage_work) += work;
  sum(external) += work;
}

// Not times the thickness.
double Ledger::unilateral_energy(std::span<const double> phi) const {
  if (!heat_) return find_unilateral_energy(motion_.discretisation(), rows_, phi, rows_.drive->committed);
  // At the temperature that the force saw, too.
  const std::vector<double> flow = rows_.history.trial, driving = rows_.drive->trial;
  const Handle<Vec> u_n = motion_.discretisation().global_of(state_.row("u").committed);
  MotionProblem::Increments unused;
  motion_.advance(u_n, unused);
  const std::vector<double> before = rows_.drive->trial;
  rows_.history.trial = flow;
  rows_.drive->trial = driving;
  return find_unilateral_energy(motion_.discretisation(), rows_, phi, before);
}

// On free dofs the change of the internal forces is the residual of a next pass, elsewhere that of the
// reactions.
void Ledger::find_coupling_error(const StepRecord& step) {
  const Handle<Vec> difference = motion_.discretisation().displacement.make_global();
  check(VecWAXPY(difference, -1, step.forces->internal, step.internal_of_next_pass));
  const PetscReal change = Get(VecNorm)(difference, NORM_2);
  const PetscReal size = Get(VecNorm)(step.forces->internal, NORM_2);
  coupling_error_ = size > 0 ? change / size : 0;
}

// Rigid bodies at rest have the energy of rounding errors: less than that of 1e-12 of a cell in a step is
// none.
void Ledger::book_scale(double dt) {
  const double speed = 1e-12 * motion_.discretisation().mesh.smallest_edge() / dt;
  for (const RigidBody& body : motion_.rigid().bodies())
    sum(scale) = std::max(sum(scale), motion_.discretisation().thickness * body.mass * speed * speed);
  sum(scale) = std::max({sum(scale), std::abs(stored() - sum(kept)), std::abs(sum(external)),
                         std::abs(sum(start_energy) - sum(kept_at_start))});
  if (heat_) sum(scale) = std::max(sum(scale), heat_->exchanged());
}

double Ledger::stored() const {
  const MaterialEnergies& total = energies_.total;
  return total.kinetic + total.elastic + total.plastic + total.fracture + total.fatigue + total.thermal +
         sum(contact_store) + sum(kept) + of_foundations(FoundationSum::store);
}

double Ledger::of_foundations(int which) const { return foundations_.trial[static_cast<std::size_t>(which)]; }

double Ledger::eroded(int which) const {
  return erosion_ == nullptr ? 0 : erosion_->trial[static_cast<std::size_t>(which)];
}

void Ledger::book_exposure(double before, double after) {
  for (const bool trial : {false, true}) {
    (trial ? totals_.trial : totals_.committed)[contact_store] += after - before;
    (trial ? erosion_->trial : erosion_->committed)[ErosionTotals::energy] += before - after;
  }
}

Ledger::Inertia Ledger::inertia(Vec u, Vec v, Vec a, double dt) {
  return {find_energies(motion_.discretisation(), rows_, u, v, false),
          motion_.discretisation().thickness * forces_.kept(dt, a)};
}

void Ledger::book_shed_mass(const Inertia& before, const Inertia& after, const std::array<double, 3>& force) {
  const double kinetic_lost = before.energies.total.kinetic - after.energies.total.kinetic,
               kept_lost = before.kept - after.kept;
  std::array<double, 3> momentum{};
  for (std::size_t m = 0; m < before.energies.of.size(); ++m)
    for (std::size_t k = 0; k < 3; ++k)
      momentum[k] += before.energies.of[m].momentum[k] - after.energies.of[m].momentum[k];
  for (const bool trial : {false, true}) {
    std::vector<double>&totals = trial ? totals_.trial : totals_.committed,
    &erosion = trial ? erosion_->trial : erosion_->committed;
    totals[Total::kinetic] -= kinetic_lost;
    totals[Total::kept] -= kept_lost;
    erosion[ErosionTotals::energy] += kinetic_lost + kept_lost;
    for (std::size_t k = 0; k < 3; ++k) {
      erosion[ErosionTotals::momentum + k] += momentum[k];
      erosion[ErosionTotals::force + k] = force[k];
    }
  }
  energies_ = after.energies;
}

double Ledger::dissipated() const {
  const double lost = sum(numerical) + sum(contact_loss) + eroded(ErosionTotals::energy) +
                      of_foundations(FoundationSum::loss);
  // The rest is thermal energy; of closing cracks where the heat balance takes the work of the stress.
  if (heat_) return state_.find("stress") ? lost : lost + sum(closing);
  return lost + sum(viscous) + sum(damage) + sum(plastic_dissipation) + sum(friction) + sum(fatigue_loss) +
         sum(closing);
}

double Ledger::energy_scale() const { return sum(scale) > 0 ? sum(scale) : sum(scale) + 1e-300; }

double Ledger::balance() const {
  return (sum(identity) + (energies_.total.kinetic - sum(kinetic))) / energy_scale();
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

} // namespace impact
