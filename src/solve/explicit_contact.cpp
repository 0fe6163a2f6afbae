#include <algorithm>
#include <impact/petsc/entries.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/field_solver.hpp>
#include <impact/petsc/log.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/solve/explicit_contact.hpp>

namespace impact {

ExplicitContact::ExplicitContact(MotionProblem& motion)
    : motion_(motion), impulses_(motion.discretisation().displacement),
      on_bodies_(motion.rigid().bodies().size()) {
  if (motion.contacts().empty()) return;
  const FieldLayout& layout = motion.discretisation().displacement;
  stiffness_ = layout.make_global();
  if (std::none_of(motion.contacts().begin(), motion.contacts().end(),
                   [](const ContactInterface& contact) { return contact.by_impulse(); }))
    return;
  for (Handle<Vec>* made : {&struck_.before, &struck_.free, &struck_.force}) *made = layout.make_global();
}

void ExplicitContact::expose(Vec u) {
  motion_.expose_contacts(u);
  frequency_ = -1;
}

void ExplicitContact::find_forces(Vec u_n, Vec u, Vec force) {
  check(VecSet(force, 0));
  if (!stiffness_) return;
  at_work_ = {};
  std::fill(on_bodies_.begin(), on_bodies_.end(), 0.0);
  add_forces(u_n, u, false, force);
  find_frequency();
}

void ExplicitContact::add_forces(Vec u_n, Vec u, bool by_impulse, Vec force) {
  for (ContactInterface& contact : motion_.contacts()) {
    if (contact.by_impulse() != by_impulse) continue;
    StiffnessBound bound{stiffness_, on_bodies_};
    contact.end_step(u_n, u, force, by_impulse ? nullptr : &bound, motion_.tally());
    if (!contact.settings().rigid()) at_work_.deepest = std::max(at_work_.deepest, bound.deepest);
  }
}

void ExplicitContact::find_frequency() {
  const Entries mass(motion_.lumped_mass());
  WritableEntries stiffness(stiffness_);
  const auto visit = [&](const auto& see) {
    for (const ContactInterface& contact : motion_.contacts())
      for (const ContactInterface::ReachedDof& dof : contact.reached()) see(dof.place);
  };
  visit([&](PetscInt i) { at_work_.frequency = std::max(at_work_.frequency, stiffness[i] / mass[i]); });
  visit([&](PetscInt i) { stiffness[i] = 0; });
  motion_.tally().largest(at_work_.numbers());
}

std::string ExplicitContact::penalties() const {
  std::string text;
  for (const ContactInterface& contact : motion_.contacts())
    if (!contact.by_impulse())
      text += text_of("%s%s %.3g", text.empty() ? "" : ", ", contact.id().c_str(), contact.penalty());
  return text;
}

void ExplicitContact::tell_of_depth() {
  if (at_work_.deepest <= 0.9 || told_) return;
  told_ = true;
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
  add_forces(now.u_n, now.u, true, struck_.force);
  check(VecAXPY(force, 1, struck_.force));
  check(VecPointwiseMult(struck_.force, struck_.force, inverse_mass));
  check(VecAXPY(a, 1, struck_.force));
}

} // namespace impact
