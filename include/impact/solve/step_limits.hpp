#pragma once
#include <impact/contact/contact_set.hpp>
#include <impact/kernel/frame.hpp>
#include <impact/problem/rigid_bodies.hpp>
#include <impact/problem/settings.hpp>
#include <string>

/// Limits on what may change in a step: -ts_adapt_dphi, _dalpha, _dtheta, _closing. A step beyond one is
/// tried again with a shorter dt, which else follows the part of the limits that was used up.
namespace impact {

class StepLimits {
public:
  StepLimits(const CouplingScenario& settings, bool inertia) : settings_(settings), inertia_(inertia) {}

  void begin(double dt);
  /// Largest increment of the attempt over its limit; 0 without limits.
  double utilisation() const { return utilisation_; }

  /// Why the step is refused; empty where it is not.
  using Refusal = std::string;
  Refusal damage(double growth);
  /// Of the histories of all points. Collective.
  Refusal plastic_strain(MPI_Comm comm, Frame frame, const StateRow& history);
  /// Collective.
  Refusal temperature(MPI_Comm comm, const StateRow& theta);
  /// Of a step whose prescribed nodes have moved to u. Collective.
  Refusal closing(const ContactSet& contacts, Vec u) const;
  /// Of a step whose bodies were expected at `goal` and are at u. Collective.
  Refusal turning(const RigidBodies& bodies, Vec goal, Vec u) const;

private:
  Refusal limit(const char* what, double increment, const char* option, double most);
  bool at_least_step() const;

  const CouplingScenario& settings_;
  bool inertia_;
  double dt_ = 0, utilisation_ = 0;
};

} // namespace impact
