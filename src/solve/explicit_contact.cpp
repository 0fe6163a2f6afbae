#include <algorithm>
#include <impact/petsc/error.hpp>
#include <impact/petsc/field_solver.hpp>
#include <impact/petsc/log.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/solve/explicit_contact.hpp>

namespace impact {

ExplicitContact::ExplicitContact(MotionProblem& motion)
    : motion_(motion), impulses_(motion.discretisation().displacement),
      on_bodies_(motion.rigid().bodies().size()) {
  const FieldLayout& layout = motion.discretisation().displacement;
  if (!motion.contacts().empty()) stiffness_ = layout.make_global();
  for (const ContactInterface& contact : motion.contacts()) {
    forces_.push_back({layout.make_global(), {}});
    if (!contact.by_impulse() || struck_.before) continue;
    for (Handle<Vec>* made : {&struck_.before, &struck_.free, &struck_.force}) *made = layout.make_global();
  }
}

void ExplicitContact::expose(Vec u) {
  motion_.expose_contacts(u);
  frequency_ = -1;
}

void ExplicitContact::find_forces(Vec u, Vec force) {
  check(VecSet(force, 0));
  if (stiffness_) check(VecSet(stiffness_, 0));
  deepest_ = 0;
  std::fill(on_bodies_.begin(), on_bodies_.end(), 0.0);
  add_forces(u, false, force);
}

void ExplicitContact::add_forces(Vec u, bool by_impulse, Vec force) {
  auto known = forces_.begin();
  for (const ContactInterface& contact : motion_.contacts()) {
    if (contact.by_impulse() == by_impulse) {
      check(VecSet(known->residual, 0));
      StiffnessBound bound{stiffness_, on_bodies_};
      known->part = contact.add_residual(u, 1, known->residual, by_impulse ? nullptr : &bound);
      if (!contact.settings().rigid()) deepest_ = std::max(deepest_, bound.deepest);
      check(VecAXPY(force, -1, known->residual));
    }
    ++known;
  }
}

double ExplicitContact::frequency_at_work() {
  if (forces_.empty()) return 0;
  check(VecPointwiseDivide(stiffness_, stiffness_, motion_.lumped_mass()));
  std::array<double, 2> most = {0, deepest_};
  const Entries squares(stiffness_);
  const PetscInt count = Get(VecGetLocalSize)(stiffness_);
  for (PetscInt i = 0; i < count; ++i) most[0] = std::max(most[0], squares[i]);
  const MPI_Comm comm = motion_.discretisation().mesh.comm();
  max_over_ranks(comm, most);
  if (most[1] > 0.9 && !told_) {
    told_ = true;
    tell_of_depth();
  }
  return most[0];
}

std::string ExplicitContact::penalties() const {
  std::string text;
  for (const ContactInterface& contact : motion_.contacts())
    if (!contact.by_impulse())
      text += text_of("%s%s %.3g", text.empty() ? "" : ", ", contact.id().c_str(), contact.penalty());
  return text;
}

void ExplicitContact::tell_of_depth() const {
  bool exposed = false;
  for (const ContactInterface& contact : motion_.contacts()) exposed = exposed || contact.settings().exposed;
  check(PetscPrintf(
      motion_.discretisation().mesh.comm(),
      "impact: WARNING: a contact is as deep as surfaces are seen in each other, half of a facet%s; "
      "what goes deeper passes through: take a larger -contact_<id>_penalty (now %s)%s\n",
      exposed ? ", a sixteenth of one that came free as cells left" : "", penalties().c_str(),
      exposed ? "" : " or -contact_<id>_enforce impulse"));
}

void ExplicitContact::add_impulses(const Motion& now, Vec inverse_mass, const ExplicitBodies& bodies,
                                   Vec force, Vec a) {
  check(VecWAXPY(struck_.before, now.dt / 2, now.a_n, now.v));
  check(VecWAXPY(struck_.free, now.dt, a, struck_.before));
  bodies.put_velocity(struck_.before, -now.dt / 2);
  bodies.put_velocity(struck_.free, now.dt / 2);
  impulses_.find(motion_.contacts(), {now.u, struck_.before, struck_.free, inverse_mass,
                                      bodies.empty() ? nullptr : &bodies, now.t, now.dt});
  check(VecSet(struck_.force, 0));
  add_forces(now.u, true, struck_.force);
  check(VecAXPY(force, 1, struck_.force));
  check(VecPointwiseMult(struck_.force, struck_.force, inverse_mass));
  check(VecAXPY(a, 1, struck_.force));
}

void ExplicitContact::advance(Vec u_n, Vec u, double dt) {
  auto known = forces_.begin();
  for (ContactInterface& contact : motion_.contacts()) {
    contact.advance(u_n, u, dt, known->residual, known->part);
    ++known;
  }
}

} // namespace impact
