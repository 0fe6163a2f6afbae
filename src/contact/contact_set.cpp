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

NodePairs ContactSet::couplings() const {
  NodePairs all;
  for (const ContactInterface& contact : contacts_) {
    const NodePairs pairs = contact.couplings();
    all.insert(all.end(), pairs.begin(), pairs.end());
  }
  return all;
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
