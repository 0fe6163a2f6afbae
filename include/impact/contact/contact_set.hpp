#pragma once
#include <deque>
#include <impact/contact/interface.hpp>

/// All contacts of a run: what the solution of a step asks of them together is the sum, the union or the
/// worst of what each one says. Those who tell contacts something, or name them one by one (columns,
/// messages), iterate.
namespace impact {

/// Contacts, which do not move. Its functions are those of ContactInterface, of all contacts; collective.
class ContactSet : public std::deque<ContactInterface> {
public:
  ContactDemands demands() const;
  bool update_search(Vec u);
  /// Before it, at the same u: what ranks tell each other then goes along with `tally`.
  void look(Vec u, Tally& tally) {
    for (ContactInterface& contact : *this) contact.search().look(u, tally);
  }
  NodePairs couplings() const;
  /// r += scale times minus the forces on the bodies.
  void add_forces(Vec u, double scale, Vec r) const {
    for (const ContactInterface& contact : *this) contact.add_residual(u, scale, r);
  }
  void add_carried(double scale, Vec r) const {
    for (const ContactInterface& contact : *this) contact.add_carried(scale, r);
  }
  void start_newton(Vec u) {
    for (ContactInterface& contact : *this) contact.start_newton(u);
  }
  void keep_multipliers() {
    for (ContactInterface& contact : *this) contact.keep_multipliers();
  }
  void swap_multipliers() {
    for (ContactInterface& contact : *this) contact.swap_multipliers();
  }
  /// Where an active set does not come to rest: multipliers outside Newton's method do not change it. Whether
  /// some methods have given way.
  bool fall_back() {
    const bool closed = demands().closes_gaps;
    for (ContactInterface& contact : *this) contact.fall_back();
    return closed && !demands().closes_gaps;
  }
  SetChange after_newton_step(Vec u, Vec du, Vec next, bool follow);
  GapsLeft gaps_left(Vec u, double force) const;
  void meet(bool loose, bool first_touch) {
    for (ContactInterface& contact : *this) contact.meet(loose, first_touch);
  }
  void scale_penalties(double factor) {
    for (ContactInterface& contact : *this) contact.scale_penalty(factor);
  }
  void ease(Vec goal) {
    for (ContactInterface& contact : *this) contact.ease(goal);
  }
  /// What an augmentation of all contacts would say: whether they converged and settled, the penetration.
  AugmentReport review(Vec u) const;
  /// [contact]
  std::vector<ContactReach> reach(Vec u) const;
  std::vector<ContactStep> step(Vec u) const;
  void advance(Vec u_n, Vec u, double dt) {
    for (ContactInterface& contact : *this) contact.advance(u_n, u, dt);
  }
  int active(Vec u) const;
  ContactFields nodal_fields(Vec u) const;
};

} // namespace impact
