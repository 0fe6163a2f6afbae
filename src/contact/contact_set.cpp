#include <algorithm>
#include <impact/contact/contact_set.hpp>

namespace impact {

ContactDemands ContactSet::demands() const {
  ContactDemands all;
  for (const ContactInterface& contact : *this) {
    const ContactDemands mine = contact.demands();
    all.closes_gaps = all.closes_gaps || mine.closes_gaps;
    all.augments = all.augments || mine.augments;
    all.frictional = all.frictional || mine.frictional;
    all.reverses = all.reverses || mine.reverses;
  }
  return all;
}

bool ContactSet::update_search(Vec u) {
  bool changed = false;
  for (ContactInterface& contact : *this) changed = contact.update_search(u) || changed;
  return changed;
}

NodePairs ContactSet::couplings() const {
  NodePairs all;
  for (const ContactInterface& contact : *this) {
    const NodePairs pairs = contact.couplings();
    all.insert(all.end(), pairs.begin(), pairs.end());
  }
  return all;
}

SetChange ContactSet::after_newton_step(Vec u, Vec du, Vec next, bool follow) {
  SetChange all;
  for (ContactInterface& contact : *this) {
    const SetChange one = contact.after_newton_step(u, du, next, follow);
    all.other = all.other || one.other;
    all.active += one.active;
  }
  return all;
}

GapsLeft ContactSet::gaps_left(Vec u, double force) const {
  GapsLeft all;
  for (const ContactInterface& contact : *this) {
    const GapsLeft left = contact.gaps_left(u, force);
    all.closed = all.closed && left.closed;
    all.open = std::max(all.open, left.open);
  }
  return all;
}

AugmentReport ContactSet::review(Vec u) const {
  AugmentReport all;
  all.converged = true;
  for (const ContactInterface& contact : *this) {
    const AugmentReport report = contact.review(u);
    all.converged = all.converged && report.converged;
    all.settled = all.settled && report.settled;
    all.penetration = std::max(all.penetration, report.penetration);
  }
  return all;
}

std::vector<ContactReach> ContactSet::reach(Vec u) const {
  std::vector<ContactReach> all;
  for (const ContactInterface& contact : *this) all.push_back(contact.reach(u));
  return all;
}

std::vector<ContactStep> ContactSet::step(Vec u) const {
  std::vector<ContactStep> all;
  for (const ContactInterface& contact : *this) all.push_back(contact.step(u));
  return all;
}

int ContactSet::active(Vec u) const {
  int active = 0;
  for (const ContactInterface& contact : *this) active += contact.measures(u).active;
  return active;
}

ContactFields ContactSet::nodal_fields(Vec u) const {
  ContactFields all;
  for (const ContactInterface& contact : *this) all = contact.nodal_fields(u, std::move(all));
  return all;
}

} // namespace impact
