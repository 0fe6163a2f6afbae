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

  ContactDemands demands() const;

  /// As of ContactInterface, of all contacts. Collective, all of these.
  void begin_attempt(double t, double mass_shift, bool stabilised);
  bool update_search(Vec u);
  void forget_search();
  NodePairs couplings() const;
  void advance(Vec u_n, Vec u, double dt);

  /// r += scale times minus the forces on the bodies.
  void add_forces(Vec u, double scale, Vec r) const;
  /// K += scale times the derivative of what add_forces adds; the caller assembles.
  void add_jacobian(Vec u, double scale, Mat K) const;
  /// y += the same times du, without a matrix.
  void apply_jacobian(Vec u, double scale, Vec du, Vec y) const;

  /// Before Newton's method starts from u.
  void start_newton(Vec u);
  /// After its step from u to `next`, du before anything was done to its end. With `follow` also what slides
  /// is followed. True when the next linear solve needs a matrix of its own.
  bool after_newton_step(Vec u, Vec du, Vec next, bool follow);
  /// r += what the right-hand side of a linear solve holds beside the residual.
  void add_gaps(Vec u, double scale, Vec r) const;
  GapsLeft gaps_left(Vec u, double force) const;
  /// Augmentations take the place of updates within Newton's method for the rest of the attempt.
  void fall_back();
  void meet(bool loose, bool first_touch);

  void start_augmentation();
  ContactReview review(Vec u) const;
  void augment(Vec u);

  /// The projection of a velocity begins: gaps are linear, without friction, multipliers start from zero; all
  /// is put back at its end.
  void begin_projection();
  void end_projection();
  /// The projection ended at w: shock += half its forces.
  void keep_shock(Vec w, Vec shock);

  /// [contact]
  std::vector<ContactInterface::Reach> reach(Vec u) const;
  double energy(Vec u) const;
  int active(Vec u) const;
  /// The smallest gap of a node, else what is largest; of vectors what is not zero.
  ContactFields nodal_fields(Vec u) const;

private:
  std::deque<ContactInterface> contacts_; // which do not move
};

} // namespace impact
