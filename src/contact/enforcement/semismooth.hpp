#pragma once
#include <impact/contact/enforcement.hpp>

namespace impact {

/// Semismooth Newton method, or primal-dual active set (S. Hueber, G. Stadler, B. Wohlmuth, SIAM J. Sci.
/// Comput. 30 (2008)): p = lambda where lambda - c g > 0 (active), else 0. The linear solves make the active
/// gaps vanish, with the weight gamma, and multipliers follow every iterate,
///   lambda <- lambda - gamma (g + dg.du)   (77'')
/// The converged state does not know c and gamma.
class Semismooth : public EnforcementMethod {
public:
  using EnforcementMethod::EnforcementMethod;
  bool presses(int index, double gap) const override;
  void press(Constraint& c) const override;
  double stiffness(const Constraint& c) const override;
  double potential(const Constraint& /*c*/) const override { return 0; } // g = 0 stores nothing
  double slip_weight() const override;
  double turn_stiffness(const Constraint& c, const Traction& t) const override;
  bool has_multipliers() const override { return true; }
  bool closes_gaps() const override { return true; }
  std::unique_ptr<EnforcementMethod> fallback() const override;
  void start_newton(const Constraints& constraints, Vec u) override;
  bool after_newton_step(const Constraints& constraints, Friction& friction, Vec u, Vec du,
                         Vec next) override;
  GapsLeft gaps_left(const Constraints& constraints, const Friction& friction, Vec u,
                     double force) const override;
  bool converged(const AugmentReport& report, const Constraints& constraints, const Friction& friction,
                 Vec u) const override;
  void augment(const AugmentReport& /*report*/, std::vector<double>& lambda) override {
    rows_.multiplier->trial = std::move(lambda);
  }
};

} // namespace impact
