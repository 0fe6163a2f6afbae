#include <cmath>
#include <impact/petsc/error.hpp>
#include <impact/petsc/log.hpp>
#include <impact/problem/coupling.hpp>
#include <impact/time/types.hpp>

/// What a run begins with, between steps: accelerations, stresses and microforces of the start.
namespace impact {

void Coupling::begin_at_rest_of_step(double t, Vec u, Vec v) {
  // Between steps the viscous stress still wants C at an earlier time: a backward step short against
  // everything else.
  const Discretisation& d = motion_.discretisation();
  read_contact_scale();
  PetscReal dt = 0;
  check(TSGetTimeStep(ts_, &dt));
  const double h = 1e-6 * dt;
  u_before_ = d.displacement.make_local();
  std::vector<double> rate = d.displacement.make_local();
  d.displacement.to_local(u, u_before_);
  d.displacement.to_local(v, rate);
  for (std::size_t i = 0; i < u_before_.size(); ++i) u_before_[i] -= h * rate[i];
  MotionStep step;
  step.t_n = t - h;
  step.t = t;
  step.dt = h;
  step.u_n = &u_before_;
  if (damage_) step.phi = &state_.row("phi").committed;
  if (heat_) step.theta = &state_.row("theta").committed;
  step.contact_scale = contact_scale_;
  step.unilateral_scale = unilateral_scale_;
  motion_.begin(step);
}

void Coupling::start_heat(Vec u) {
  if (!heat_ || !settings_.moves) return;
  const HeatRows rows = heat_->rows();
  if (!rows.stress) return;
  MotionProblem::Increments unused;
  motion_.advance(u, unused, {nullptr, rows.stress});
  state_.row("stress").committed = *rows.stress;
  state_.rollback();
}

void Coupling::start_damage(Vec u) {
  if (!damage_) return;
  motion_.discretisation().displacement.to_local(u, u_local_);
  damage_->start(u_local_);
}

double Coupling::prescribed_damage_work() const {
  return damage_ && !(heat_ && heat_->takes_work_of_damage()) ? damage_->prescribed_work() : 0;
}

void Coupling::initial_acceleration(double t, Vec u, Vec v, Vec a) {
  // M a_0 = F_ext - F_int(u_0, v_0) without contact on the free dofs; prescribed dofs keep the rate of their
  // data.
  const Discretisation& d = motion_.discretisation();
  begin_at_rest_of_step(t, u, v);
  ForceParts forces;
  motion_.parts(u, forces);
  check(VecAXPY(forces.external, -1, forces.internal));
  d.displacement.to_global(state_.row("a").committed, a);
  motion_.mass_solve(forces.external, a);
  motion_.rigid().accelerate(forces.external, a);
}

} // namespace impact
