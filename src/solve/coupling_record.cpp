#include <impact/petsc/field_solver.hpp>
#include <impact/solve/coupling.hpp>
#include <impact/time/types.hpp>

/// What is told of a solved step, or of one that could not be solved.
namespace impact {

Attempt Coupling::first_loads(const Attempt& attempt) const {
  if (const ArcLength* const arc = solver_.arc_length())
    return {arc->start(), attempt.dt, arc->start(), attempt.number};
  return path_ ? Attempt{path_->start(), attempt.dt, path_->guess(attempt.dt), attempt.number} : attempt;
}

Attempt Coupling::loads(const Attempt& attempt) const {
  const MotionStep& step = fields_.motion.step();
  return path_ || solver_.arc_length() ? Attempt{step.t_n, attempt.dt, step.t, attempt.number} : attempt;
}

std::string Coupling::failure_text() const {
  const std::string cell = solver_.cell_broke() ? fields_.motion.broken_text() : "";
  return cell.empty() ? failure_ : cell;
}

void Coupling::give_up(PetscInt passes, PetscReal change) {
  const bool conducts = std::ranges::any_of(fields_.motion.contacts(),
                                            [](const auto& c) { return c.settings().conductance > 0; });
  failure_ =
      text_of("%d passes%s, %s still changes by %.2g (-coupling_snes_max_it)%s", static_cast<int>(passes),
              settings_.follow_cracks ? " in which phi does not grow" : "", pass_.changing, change,
              conducts ? "; a contact passes heat: see -contact_<id>_conductance_exponent" : "");
}

StepCounts Coupling::counts() const {
  StepCounts counts = counts_;
  const MotionSolver::Counts& motion = solver_.counts();
  counts.newton = motion.newton;
  counts.linear = motion.linear;
  counts.longest = motion.longest;
  counts.hardest = motion.hardest;
  counts.uzawa = augmentation_.passes();
  counts.passes = pass_.number;
  return counts;
}

StepRecord Coupling::record(Vec u) {
  MotionProblem& motion = fields_.motion;
  StepRecord record;
  record.dt = motion.step().dt;
  record.first = Get(TSGetStepNumber)(ts_) == 0;
  record.integrator = integrator_of(ts_);
  if (record.integrator.inertia) record.start_velocity = start_velocity(ts_);
  record.counts = counts();
  record.stabilised = update_.stabilised();
  record.unilateral = update_.unilateral();
  if (!record.unilateral && !explicit_) motion.parts(u, forces_);
  record.forces = record.unilateral ? &update_.forces() : explicit_ ? &explicit_->forces() : &forces_;
  record.contact_force = explicit_ ? explicit_->forces().contact : augmentation_.contact_force();
  record.contact_at_end =
      record.integrator.inertia && update_.corrects() ? update_.contact_at_end() : record.contact_force;
  record.left = augmentation_.left();
  if (explicit_) record.bodies = explicit_->bodies().work();
  record.closing_at_end = update_.closing_at_end();
  record.over_step = update_.over_step();
  record.hidden = update_.hidden();
  record.contact_shock = update_.shock();
  record.contact_acceleration = update_.acceleration();
  record.told_velocity = update_.told();
  record.increments = &pass_.increments;
  record.phi = pass_.phi;
  record.dissipation = pass_.dissipation;
  if (const DamageProblem* damage = fields_.damage) {
    record.damage_dissipation = damage->dissipated();
    const bool in_heat = fields_.heat && fields_.heat->takes_work_of_damage();
    record.prescribed_damage_work = in_heat ? 0 : damage->prescribed_work();
  }
  record.fatigue_dissipation = fatigue_.dissipated;
  record.least_fatigue = fatigue_.least;
  if (fields_.heat) record.heat = &fields_.heat->supplied();
  if (settings_.report_error) {
    const std::vector<double> phi = pass_.phi, theta = pass_.theta, warming = pass_.warming;
    if (fields_.damage) pass_.phi = fields_.state.row("phi").trial;
    if (fields_.heat) pass_.theta = fields_.state.row("theta").trial;
    if (warming_) pass_.warming = warming_->trial;
    motion.parts(u, next_);
    pass_.phi = phi;
    pass_.theta = theta;
    pass_.warming = warming;
    record.internal_of_next_pass = next_.internal;
  }
  if (!explicit_ && fields_.erosion != nullptr) fields_.erosion->find_failed(u); // after the last pass
  return record;
}

} // namespace impact
