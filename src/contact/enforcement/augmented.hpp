#pragma once
#include <impact/contact/enforcement.hpp>

namespace impact {

/// Augmented Lagrangian: after every solve lambda <- <lambda - eps g> (75'), 0 where a constraint faces
/// nothing; then the penalty grows by its rule, which the settings name.
class AugmentedLagrangian : public EnforcementMethod {
public:
  using EnforcementMethod::EnforcementMethod;
  bool has_multipliers() const override { return true; }
  bool augments() const override { return true; }
  bool converged(const AugmentReport& report, const Constraints& constraints, const Friction& friction,
                 Vec u) const override;
  void augment(const AugmentReport& report, std::vector<double>& lambda) override;
};

} // namespace impact
