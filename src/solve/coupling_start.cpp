#include <impact/solve/coupling.hpp>
#include <impact/time/types.hpp>

/// What a run begins with, between steps: stresses, microforces and accelerations of the start.
namespace impact {

// Between steps the viscous stress still wants C at an earlier time: a backward step short against everything
// else.
void Coupling::begin_between_steps(double t, Vec u, Vec v) {
  const FieldLayout& layout = fields_.motion.discretisation().displacement;
  PetscReal dt = 0;
  check(TSGetTimeStep(ts_, &dt));
  const double h = 1e-6 * dt;
  u_before_ = layout.make_local();
  std::vector<double> rate = layout.make_local();
  layout.to_local(u, u_before_);
  layout.to_local(v, rate);
  for (std::size_t i = 0; i < u_before_.size(); ++i) u_before_[i] -= h * rate[i];
  MotionStep step = frozen_step();
  step.t_n = t - h;
  step.t = t;
  step.dt = h;
  step.u_n = &u_before_;
  if (fields_.damage) step.phi = &fields_.state.row("phi").committed;
  if (fields_.heat) step.theta = &fields_.state.row("theta").committed;
  fields_.motion.begin(step);
}

void Coupling::start(Vec u, Vec a) {
  MotionProblem& motion = fields_.motion;
  StateTable& state = fields_.state;
  const FieldLayout& layout = motion.discretisation().displacement;
  if (fields_.heat && settings_.moves)
    if (const HeatRows rows = fields_.heat->rows(); rows.stress) {
      MotionProblem::Increments unused;
      motion.advance(u, unused, {nullptr, rows.stress});
      state.row("stress").committed = *rows.stress;
      state.rollback();
    }
  if (fields_.damage) {
    layout.to_local(u, pass_.u);
    fields_.damage->start(pass_.u);
  }
  if (!integrator_of(ts_).inertia) return;
  // M a_0 = F_ext - F_int(u_0, v_0) without contact on the free dofs; prescribed dofs keep the rate of their
  // data.
  ForceParts forces;
  motion.parts(u, forces);
  check(VecAXPY(forces.external, -1, forces.internal));
  layout.to_global(state.row("a").committed, a);
  motion.mass_solve(forces.external, a);
  motion.rigid().accelerate(forces.external, a);
  set_acceleration(ts_, a);
}

} // namespace impact
