#pragma once
#include <impact/contact/interface.hpp>

/// Heat across one contact in a step with the displacement frozen (theory.md, heat): at every closed place c
///   q_c = h_c A_c [theta]_c,   [theta]_c = sum_secondary N theta - sum_primary N theta (or the rigid
///   body's),
/// whose potential 1/2 h A [theta]^2 has a symmetric, not negative tangent that couples both sides, and the
/// heat that sliding made, in fixed parts on both sides. Shares sum to one on either side: what one side
/// loses the other gains, to rounding. Everything is an energy per step and per unit thickness.
namespace impact {

class ContactHeat {
public:
  /// Mesh and contact must outlive it. Collective.
  ContactHeat(const Mesh& mesh, const ContactInterface& contact);

  const ContactInterface& contact() const { return *contact_; }
  /// Pairs of global nodes that the tangent may couple, as of the last renew: sorted, each once.
  const NodePairs& couplings() const { return couplings_; }
  /// Follows the contact's search; true on all ranks when the couplings changed. Collective.
  bool renew();

  /// Fixes what the step takes from the motion that ended at u: `weight` weighs t_{n+1} against t_n,
  /// `rigid_theta` is the rigid body's temperature in the step. Collective.
  void begin(Vec u, Vec theta_n, double dt, double weight, double rigid_theta);
  /// r += heat that leaves the nodes. Collective.
  void add_residual(Vec theta, Vec r) const;
  /// K += its derivative by MatSetValues, without rows and columns of nodes with held != 0 (a nodal vector);
  /// the caller assembles. Collective for the exchange of `held`.
  void add_tangent(Vec held, Mat K) const;

  struct Heat {
    double conducted = 0; ///< into the secondary side
    double friction = 0;  ///< made in the step
    double outside = 0;   ///< that bodies of the mesh gained beyond it: what a rigid body gave, less its part
                          ///< of the frictional heat
  };
  /// What passed with the temperature theta; nodal += heat that the rigid body conducted into each node.
  /// Collective.
  Heat book(Vec theta, Vec nodal) const;

private:
  std::vector<double> weighted(Vec theta) const; // [node] of the contact
  bool rigid() const { return contact_->settings().rigid(); }
  double jump(const HeatPath& path, const std::vector<double>& theta) const;
  double flow(const HeatPath& path, const std::vector<double>& theta) const; // out of the secondary side

  const Mesh* mesh_;
  const ContactInterface* contact_;
  long searches_ = -1;
  double split_;
  bool conducts_;
  NodeExchange exchange_;
  NodePairs couplings_;
  std::vector<HeatPath> paths_;
  std::vector<double> theta_n_;
  double dt_ = 0, weight_ = 1, rigid_theta_ = 0;
};

} // namespace impact
