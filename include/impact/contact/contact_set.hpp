#pragma once
#include <deque>
#include <impact/contact/interface.hpp>
#include <vector>

/// All contacts of a run as one object: what the solution of a step asks of them is the sum, the union or the
/// worst of what each one says. Those who name contacts one by one (columns, messages) iterate. More
/// functions than usual: every one is a loop over the contacts that would otherwise stand at each of its
/// callers.
namespace impact {

/// What an augmentation of all contacts would say.
struct ContactReview {
  bool converged = true, settled = true;
  double penetration = 0;
};

class ContactSet {
public:
  /// Arguments of the constructor of ContactInterface. Collective.
  template <class... Arguments> ContactInterface& emplace_back(Arguments&&... arguments) {
    return contacts_.emplace_back(std::forward<Arguments>(arguments)...);
  }
  bool empty() const { return contacts_.empty(); }
  std::size_t size() const { return contacts_.size(); }
  auto begin() { return contacts_.begin(); }
  auto end() { return contacts_.end(); }
  auto begin() const { return contacts_.begin(); }
  auto end() const { return contacts_.end(); }
  ContactInterface& operator[](std::size_t i) { return contacts_[i]; }
  const ContactInterface& operator[](std::size_t i) const { return contacts_[i]; }

  /// As of ContactInterface, of all contacts. Collective, all of these.
  ContactDemands demands() const;
  void begin_attempt(double t, double mass_shift, bool stabilised) {
    each([&](auto& contact) { contact.set_time(t, mass_shift, stabilised); });
  }
  bool update_search(Vec u) {
    return any([&](auto& contact) { return contact.update_search(u); });
  }
  void forget_search() {
    each([](auto& contact) { contact.forget_search(); });
  }
  NodePairs couplings() const;
  void advance(Vec u_n, Vec u, double dt) {
    each([&](auto& contact) { contact.advance(u_n, u, dt); });
  }

  /// r += scale times minus the forces on the bodies.
  void add_forces(Vec u, double scale, Vec r) const {
    for (const auto& contact : contacts_) contact.add_residual(u, scale, r);
  }
  /// K += scale times the derivative of what add_forces adds; the caller assembles.
  void add_jacobian(Vec u, double scale, Mat K) const {
    for (const auto& contact : contacts_) contact.add_tangent(u, scale, K);
  }
  /// y += the same times du, without a matrix.
  void apply_jacobian(Vec u, double scale, Vec du, Vec y) const {
    for (const auto& contact : contacts_) contact.multiply(u, scale, du, y);
  }

  void start_newton(Vec u) {
    each([&](auto& contact) { contact.start_newton(u); });
  }
  bool after_newton_step(Vec u, Vec du, Vec next, bool follow) {
    return any([&](auto& contact) { return contact.after_newton_step(u, du, next, follow); });
  }
  void add_gaps(Vec u, double scale, Vec r) const {
    for (const auto& contact : contacts_) contact.add_gaps(u, scale, r);
  }
  GapsLeft gaps_left(Vec u, double force) const;
  void fall_back() {
    each([](auto& contact) { contact.fall_back(); });
  }
  void meet(bool loose, bool first_touch) {
    each([&](auto& contact) { contact.meet(loose, first_touch); });
  }

  void start_augmentation() {
    each([](auto& contact) { contact.start_augmentation(); });
  }
  ContactReview review(Vec u) const;
  void augment(Vec u) {
    each([&](auto& contact) { contact.augment(u); });
  }

  void begin_projection() {
    each([](auto& contact) { contact.begin_projection(); });
  }
  void end_projection() {
    each([](auto& contact) { contact.end_projection(); });
  }
  /// The projection ended at w: shock += half its forces.
  void keep_shock(Vec w, Vec shock) {
    add_forces(w, -0.5, shock);
    each([&](auto& contact) { contact.keep_shock(w); });
  }

  /// [contact]
  std::vector<ContactInterface::Reach> reach(Vec u) const;
  double energy(Vec u) const;
  int active(Vec u) const;
  /// The smallest gap of a node, else what is largest; of vectors what is not zero.
  ContactFields nodal_fields(Vec u) const;

private:
  template <class Call> void each(Call&& call) {
    for (ContactInterface& contact : contacts_) call(contact);
  }
  template <class Call> bool any(Call&& call) { // which all are asked
    bool found = false;
    for (ContactInterface& contact : contacts_) found = call(contact) || found;
    return found;
  }

  std::deque<ContactInterface> contacts_; // which do not move
};

} // namespace impact
