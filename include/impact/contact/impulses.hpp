#pragma once
#include <impact/contact/contact_set.hpp>
#include <impact/contact/impulse_rows.hpp>
#include <vector>

/// Contact of steps by central differences through impulses at the secondary nodes (theory.md, 7). Pressures
/// p_A at the nodes act at the displacement u_{n+1}; the velocity after them, by the lumped mass M, is
///   v+ = v_free + dt M^-1 F(p),    0 <= p_A  at right angles to  sum_q w N_A (dg.v+) + W_A c_A >= 0
///   c_A = max(g_A/dt, dg_A/dt before, 0)
/// where M^-1 moves the nodes of a rigid body as one,
/// so that a gap closes to zero, and no further; where p_A > 0 the mean of the velocities before and after
/// does not open it, which is why contact gives no energy (J. Moreau's law of impact; N. Carpenter, R.
/// Taylor, M. Katona, Int. J. Numer. Meth. Engng. 32 (1991)). Coulomb's law is met by v+: tractions in a disc
/// of radius mu p_A, against the slip that is left.
namespace impact {

class ContactImpulses {
public:
  explicit ContactImpulses(const FieldLayout& layout)
      : sum_(layout.make_global()), gain_(layout.make_global()) {}

  /// Pressures and tractions of all contacts that take them (ContactInterface::by_impulse) into the trial
  /// halves of their rows. Collective.
  void find(ContactSet& contacts, const ImpulseStep& step);
  /// Of the last search: how many it took; 0 where nothing came together.
  int iterations() const { return iterations_; }

private:
  bool meet(ImpulseRows& rows, const ImpulseStep& step);
  void find_bounds(const ImpulseStep& step);
  void find_velocities(const ImpulseStep& step);
  void find_rates(ImpulseRows& rows);
  bool improve(double& momentum);
  void sum(const ImpulseRows& rows, std::vector<double>& nodal);
  void sum_all(std::vector<double> ImpulseRows::*nodal);
  void gather_gain();
  void list_touched(const ContactSet& contacts);

  Handle<Vec> sum_, gain_;        // gain: of rigid bodies, 0 elsewhere
  std::vector<PetscInt> touched_; // owned dofs of contacts
  long searches_ = -1;
  std::vector<ImpulseRows> rows_;
  int iterations_ = 0;
};

} // namespace impact
