#include <algorithm>
#include <cmath>
#include <impact/contact/contact_set.hpp>

namespace impact {

ContactDemands ContactSet::demands() const {
  ContactDemands all;
  for (const ContactInterface& contact : contacts_) {
    const ContactDemands mine = contact.demands();
    all.closes_gaps = all.closes_gaps || mine.closes_gaps;
    all.augments = all.augments || mine.augments;
    all.frictional = all.frictional || mine.frictional;
    all.reverses = all.reverses || mine.reverses;
  }
  return all;
}

void ContactSet::begin_attempt(double t, double mass_shift, bool stabilised) {
  for (ContactInterface& contact : contacts_) contact.set_time(t, mass_shift, stabilised);
}

bool ContactSet::update_search(Vec u) {
  bool changed = false;
  for (ContactInterface& contact : contacts_) changed = contact.update_search(u) || changed;
  return changed;
}

void ContactSet::forget_search() {
  for (ContactInterface& contact : contacts_) contact.forget_search();
}

NodePairs ContactSet::couplings() const {
  NodePairs all;
  for (const ContactInterface& contact : contacts_) {
    const NodePairs pairs = contact.couplings();
    all.insert(all.end(), pairs.begin(), pairs.end());
  }
  return all;
}

void ContactSet::advance(Vec u_n, Vec u, double dt) {
  for (ContactInterface& contact : contacts_) contact.advance(u_n, u, dt);
}

void ContactSet::add_forces(Vec u, double scale, Vec r) const {
  for (const ContactInterface& contact : contacts_) contact.add_residual(u, scale, r);
}

void ContactSet::add_jacobian(Vec u, double scale, Mat K) const {
  for (const ContactInterface& contact : contacts_) contact.add_tangent(u, scale, K);
}

void ContactSet::apply_jacobian(Vec u, double scale, Vec du, Vec y) const {
  for (const ContactInterface& contact : contacts_) contact.multiply(u, scale, du, y);
}

void ContactSet::start_newton(Vec u) {
  for (ContactInterface& contact : contacts_) contact.start_newton(u);
}

bool ContactSet::after_newton_step(Vec u, Vec du, Vec next, bool follow) {
  bool other = false;
  for (ContactInterface& contact : contacts_) other = contact.after_newton_step(u, du, next, follow) || other;
  return other;
}

void ContactSet::add_gaps(Vec u, double scale, Vec r) const {
  for (const ContactInterface& contact : contacts_) contact.add_gaps(u, scale, r);
}

GapsLeft ContactSet::gaps_left(Vec u, double force) const {
  GapsLeft all;
  for (const ContactInterface& contact : contacts_) {
    const GapsLeft left = contact.gaps_left(u, force);
    all.closed = all.closed && left.closed;
    all.open = std::max(all.open, left.open);
  }
  return all;
}

void ContactSet::fall_back() {
  for (ContactInterface& contact : contacts_)
    if (contact.demands().closes_gaps) contact.fall_back();
}

void ContactSet::meet(bool loose, bool first_touch) {
  for (ContactInterface& contact : contacts_) contact.meet(loose, first_touch);
}

void ContactSet::start_augmentation() {
  for (ContactInterface& contact : contacts_) contact.start_augmentation();
}

ContactReview ContactSet::review(Vec u) const {
  ContactReview all;
  for (const ContactInterface& contact : contacts_) {
    const AugmentReport report = contact.review(u);
    all.converged = all.converged && report.converged;
    all.settled = all.settled && report.settled;
    all.penetration = std::max(all.penetration, report.penetration);
  }
  return all;
}

void ContactSet::augment(Vec u) {
  for (ContactInterface& contact : contacts_) contact.augment(u);
}

void ContactSet::begin_projection() {
  for (ContactInterface& contact : contacts_) contact.begin_projection();
}

void ContactSet::end_projection() {
  for (ContactInterface& contact : contacts_) contact.end_projection();
}

void ContactSet::keep_shock(Vec w, Vec shock) {
  for (ContactInterface& contact : contacts_) {
    contact.add_residual(w, -0.5, shock);
    contact.keep_shock(w);
  }
}

std::vector<ContactInterface::Reach> ContactSet::reach(Vec u) const {
  std::vector<ContactInterface::Reach> all;
  for (const ContactInterface& contact : contacts_) all.push_back(contact.reach(u));
  return all;
}

double ContactSet::energy(Vec u) const {
  double energy = 0;
  for (const ContactInterface& contact : contacts_) energy += contact.measures(u).energy;
  return energy;
}

int ContactSet::active(Vec u) const {
  int active = 0;
  for (const ContactInterface& contact : contacts_) active += contact.measures(u).active;
  return active;
}

ContactFields ContactSet::nodal_fields(Vec u) const {
  ContactFields all;
  for (const ContactInterface& contact : contacts_) {
    const ContactFields mine = contact.nodal_fields(u);
    all.gap.resize(mine.gap.size(), std::numeric_limits<double>::quiet_NaN());
    for (auto field :
         {&ContactFields::pressure, &ContactFields::status, &ContactFields::traction, &ContactFields::slip})
      (all.*field).resize((mine.*field).size(), 0.0);
    const auto merge = [](std::vector<double>& to, const std::vector<double>& from, auto&& counts) {
      for (std::size_t i = 0; i < to.size(); ++i)
        if (counts(from[i], to[i])) to[i] = from[i];
    };
    const auto larger = [](double value, double other) { return value > other; };
    const auto present = [](double value, double) { return value != 0; };
    merge(all.gap, mine.gap, [](double value, double other) { return !(other <= value); });
    merge(all.pressure, mine.pressure, larger);
    merge(all.status, mine.status, larger);
    merge(all.traction, mine.traction, present);
    merge(all.slip, mine.slip, present);
  }
  return all;
}

} // namespace impact
