#include <algorithm>
#include <cmath>
#include <impact/contact/enforcement.hpp>
#include <impact/kernel/contact_pair.hpp>
#include <impact/petsc/ranks.hpp>

namespace impact {

bool EnforcementRows::press_anywhere(MPI_Comm comm) const {
  const std::vector<double>& lambda = multiplier->trial;
  const int presses = std::any_of(lambda.begin(), lambda.end(), [](double p) { return p > 0; });
  return max_over_ranks(comm, presses) != 0;
}

void EnforcementMethod::press(Constraint& c) const {
  c.lambda = rows_.lambda(c.index);
  c.active = presses(c.index, c.gap);
  c.pressure = c.active ? c.lambda - eps() * c.gap : 0;
}

double EnforcementMethod::potential(const Constraint& c) const {
  return contact_potential(c.lambda, eps(), c.gap);
}

double EnforcementMethod::turn_stiffness(const Constraint& /*c*/, const Traction& t) const {
  const double limit = std::hypot(t.value[0], t.value[1]);
  return eps() * limit / (limit + t.excess);
}

std::unique_ptr<EnforcementMethod> make_enforcement(const ContactSettings& settings,
                                                    const EnforcementRows& rows, bool conserving) {
  if (settings.own_enforcement) return settings.own_enforcement(settings, rows);
  if (settings.enforce == Enforcement::impulse) return make_impulse(settings, rows);
  if (!conserving && settings.enforce == Enforcement::semismooth) return make_semismooth(settings, rows);
  if (!conserving && settings.enforce != Enforcement::penalty) return make_augmented(settings, rows);
  return make_penalty(settings, rows, conserving);
}

} // namespace impact
