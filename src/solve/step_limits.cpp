#include <algorithm>
#include <cmath>
#include <impact/kernel/point_data.hpp>
#include <impact/math/index.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/discretisation.hpp>
#include <impact/solve/step_limits.hpp>

namespace impact {

void StepLimits::begin(double dt) {
  dt_ = dt;
  utilisation_ = 0;
}

// What jumps in any step, such as a rate-independent crack, may do so in one below a thousandth of -ts_dt.
bool StepLimits::at_least_step() const { return dt_ <= 1e-3 * settings_.dt; }

StepLimits::Refusal StepLimits::limit(const char* what, double increment, const char* option, double most) {
  utilisation_ = std::max(utilisation_, increment / most);
  if (increment <= most || at_least_step()) return "";
  return text_of("%s by %.3g, -ts_adapt_%s is %.3g", what, increment, option, most);
}

StepLimits::Refusal StepLimits::damage(double growth) {
  if (settings_.max_dphi <= 0) return "";
  return limit("phi grows", growth, "dphi", settings_.max_dphi);
}

StepLimits::Refusal StepLimits::plastic_strain(MPI_Comm comm, Frame frame, const StateRow& history) {
  if (settings_.max_dalpha <= 0) return "";
  const double growth = largest_alpha(frame, history.trial, history.committed);
  return limit("the plastic strain grows", max_over_ranks(comm, growth), "dalpha", settings_.max_dalpha);
}

StepLimits::Refusal StepLimits::temperature(MPI_Comm comm, const StateRow& theta) {
  if (settings_.max_dtheta <= 0) return "";
  double change = 0;
  for (std::size_t i = 0; i < theta.trial.size(); ++i)
    change = std::max(change, std::abs(theta.trial[i] - theta.committed[i]));
  return limit("the temperature changes", max_over_ranks(comm, change), "dtheta", settings_.max_dtheta);
}

// Turned by half a turn about the middle of a body a slip of its rim is the same and its forces may balance,
// too, with a velocity that is none: Cayley's vector has no bound there.
StepLimits::Refusal StepLimits::turning(const RigidBodies& bodies, Vec goal, Vec u) const {
  constexpr double most = 1; // radian
  if (!inertia_ || bodies.empty()) return "";
  const auto [angle, body] = bodies.most_turned(goal, u);
  if (angle <= most) return "";
  return text_of("body %.80s would turn by %.3g radians more or less than it did before",
                 bodies.bodies()[body].name.c_str(), angle);
}

// What flies deep into another body within a step leaves Newton's method a start with cells turned inside
// out, whose balance need not be that of the bodies.
StepLimits::Refusal StepLimits::closing(const ContactSet& contacts, Vec u) const {
  if (!inertia_ || settings_.max_closing <= 0 || at_least_step()) return "";
  for (const ContactInterface& contact : contacts) {
    const double depth = contact.constraints().closed_within_step(u, settings_.max_closing);
    if (depth > 0)
      return text_of("contact %.80s would close %.3g facets deep, -ts_adapt_closing is %.3g",
                     contact.id().c_str(), depth, settings_.max_closing);
  }
  return "";
}

} // namespace impact
