#include <algorithm>
#include <impact/contact/constraints.hpp>
#include <impact/contact/enforcement.hpp>
#include <impact/contact/friction.hpp>

namespace impact {

namespace {

// A gap that fell by less than this factor makes the penalty grow.
constexpr double wanted_fall = 4;

// Where nothing presses yet, the first solves of a step take this part of the automatic penalty, 10 E/h: the
// stiffness of the surface. Points that lie deep press with more than E at all of it, and throw their
// neighbours off, cells with them; surfaces at rest that meet all over flow long before.
constexpr double first_part = 0.1;
constexpr double part_growth = 4; // up to all of it
// What a support or an obstacle has passed through before Newton's method begins presses with that part of E
// at its deepest point: less than most metals flow at.
constexpr double gentle_strain = 2e-3, gentle_growth = 10;

// Augmented Lagrangian: after every solve lambda <- <lambda - eps g> (75'), 0 where a constraint faces
// nothing; then the penalty grows by its rule, which the settings name.
class AugmentedLagrangian : public EnforcementMethod {
public:
  using EnforcementMethod::EnforcementMethod;
  bool has_multipliers() const override { return true; }
  bool augments() const override { return true; }
  bool converged(const AugmentReport& report, const Constraints&, const Friction&, Vec) const override {
    const bool in_part = report.multiplier > 0 && report.penalty < settings_->penalty;
    return !in_part && report.settled && report.penetration < settings_->gap_tol &&
           std::min(report.change, report.force_change) < settings_->pressure_tol;
  }
  void begin_attempt(const Constraints& constraints, const Friction& friction) override {
    if (!settings_->automatic_penalty || settings_->growth == PenaltyGrowth::every_augmentation) return;
    if (rows_.press_anywhere(constraints.comm())) return;
    double& penalty = rows_.penalty->trial[EnforcementRows::value];
    // With friction and inertia the pressures of the first solve say what sticks, also where a run without
    // inertia left a part of the penalty.
    const bool whole = settings_->inertia && friction.acts();
    penalty = whole ? std::max(penalty, settings_->penalty) : first_part * settings_->penalty;
  }
  bool ease(const Constraints& constraints, double depth) override {
    if (!settings_->automatic_penalty || settings_->growth == PenaltyGrowth::every_augmentation) return false;
    const double part = gentle_strain * constraints.mean_length() / (10 * depth);
    if (!(part < first_part)) return false;
    rows_.penalty->trial[EnforcementRows::value] = part * settings_->penalty;
    return true;
  }
  void augment(const AugmentReport& report, std::vector<double>& lambda) override {
    rows_.multiplier->trial = std::move(lambda);
    std::vector<double>& row = rows_.penalty->trial;
    double &penalty = row[EnforcementRows::value], &before = row[EnforcementRows::last_gap];
    const bool slow = before > 0 && report.largest_gap > before / wanted_fall;
    const double first = first_part * settings_->penalty;
    if (penalty < settings_->penalty) {
      if (before > 0)
        penalty = penalty < first ? std::min(gentle_growth * penalty, first)
                                  : std::min(part_growth * penalty, settings_->penalty);
    } else if (settings_->growth == PenaltyGrowth::every_augmentation || slow)
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
