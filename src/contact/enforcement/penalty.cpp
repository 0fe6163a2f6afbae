#include "penalty.hpp"
#include <impact/kernel/contact_pair.hpp>

namespace impact {

void ConservingPenalty::press(Constraint& c) const {
  if (!c.works_exactly()) return Penalty::press(c);
  c.pressure = secant_pressure(eps(), c.start_gap, c.gap).p;
  c.active = c.pressure > 0;
}

double ConservingPenalty::stiffness(const Constraint& c) const {
  return c.works_exactly() ? -2 * secant_pressure(eps(), c.start_gap, c.gap).slope : Penalty::stiffness(c);
}

} // namespace impact
