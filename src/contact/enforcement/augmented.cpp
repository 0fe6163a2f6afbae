#include <algorithm>
#include <impact/contact/constraints.hpp>
#include <impact/contact/enforcement.hpp>
#include <impact/contact/friction.hpp>
#include <impact/petsc/ranks.hpp>

namespace impact {

namespace {

// A gap that fell by less than this factor makes the penalty grow.
constexpr double wanted_fall = 4;

// Where nothing presses yet and points lie deeper than this part of a facet, they press with more than E at
// the automatic penalty, 10 E/h, and throw their neighbours off, cells with them. The first solve takes this
// part of the penalty then, the stiffness of the surface.
constexpr double deep = 0.1, first_part = 0.1;

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
  // With friction the pressures of the first solve say what sticks.
  void start_step(const Constraints& constraints, const Friction& friction, Vec u) override {
    if (!settings_->automatic_penalty || settings_->growth == PenaltyGrowth::every_augmentation) return;
    if (friction.acts()) return;
    const std::vector<double>& lambda = rows_.multiplier->trial;
    const int presses = std::any_of(lambda.begin(), lambda.end(), [](double p) { return p > 0; });
    if (max_over_ranks(constraints.comm(), presses) != 0) return; // with all of the penalty, or more
    double depth = 0;
    constraints.visit(u, Derivatives::none, [&](const Constraint& c) { depth = std::max(depth, -c.gap); });
    const bool first_touch = max_over_ranks(constraints.comm(), depth) > deep * constraints.mean_length();
    double& penalty = rows_.penalty->trial[EnforcementRows::value];
    penalty = first_touch ? first_part * settings_->penalty : std::max(penalty, settings_->penalty);
  }
  void augment(const AugmentReport& report, std::vector<double>& lambda) override {
    rows_.multiplier->trial = std::move(lambda);
    std::vector<double>& row = rows_.penalty->trial;
    double &penalty = row[EnforcementRows::value], &before = row[EnforcementRows::last_gap];
    penalty = std::max(penalty, settings_->penalty);
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
