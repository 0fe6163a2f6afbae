#include "augmented.hpp"
#include <algorithm>

namespace impact {

namespace {

// A gap that fell by less than this factor makes the penalty grow.
constexpr double wanted_fall = 4;

} // namespace

bool AugmentedLagrangian::converged(const AugmentReport& report, const Constraints&, const Friction&,
                                    Vec) const {
  return report.settled && report.penetration < settings_->gap_tol &&
         std::min(report.change, report.force_change) < settings_->pressure_tol;
}

void AugmentedLagrangian::augment(const AugmentReport& report, std::vector<double>& lambda) {
  rows_.multiplier->trial = std::move(lambda);
  std::vector<double>& row = rows_.penalty->trial;
  double &penalty = row[EnforcementRows::value], &before = row[EnforcementRows::last_gap];
  const bool slow = before > 0 && report.largest_gap > before / wanted_fall;
  if (settings_->growth == PenaltyGrowth::every_augmentation || slow)
    penalty = std::max(penalty, std::min(penalty + settings_->penalty_increment, settings_->penalty_max));
  before = report.largest_gap;
}

} // namespace impact
