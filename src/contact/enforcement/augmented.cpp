#include <algorithm>
#include <impact/contact/enforcement.hpp>

namespace impact {

namespace {

// A gap that fell by less than this factor makes the penalty grow.
constexpr double wanted_fall = 4;

// Augmented Lagrangian: after every solve lambda <- <lambda - eps g> (75'), 0 where a constraint faces
// nothing; then the penalty grows by its rule, which the settings name.
class AugmentedLagrangian : public EnforcementMethod {
public:
  using EnforcementMethod::EnforcementMethod;
  bool has_multipliers() const override { return true; }
  bool augments() const override { return true; }
  bool converged(const AugmentReport& report, const Constraints&, const Friction&, Vec) const override {
    return report.settled && report.penetration < settings_->gap_tol &&
           std::min(report.change, report.force_change) < settings_->pressure_tol;
  }
  void augment(const AugmentReport& report, std::vector<double>& lambda) override {
    rows_.multiplier->trial = std::move(lambda);
    std::vector<double>& row = rows_.penalty->trial;
    double &penalty = row[EnforcementRows::value], &before = row[EnforcementRows::last_gap];
    const bool slow = before > 0 && report.largest_gap > before / wanted_fall;
    if (settings_->growth == PenaltyGrowth::every_augmentation || slow)
      penalty = std::max(penalty, std::min(penalty + settings_->penalty_increment, settings_->penalty_max));
    before = report.largest_gap;
  }
};

} // namespace

std::unique_ptr<EnforcementMethod> make_augmented(const ContactSettings& settings,
                                                  const EnforcementRows& rows) {
  return std::make_unique<AugmentedLagrangian>(settings, rows);
}

} // namespace impact
