#include <impact/contact/enforcement.hpp>
#include <impact/kernel/contact_pair.hpp>

namespace impact {

namespace {

// A penalty whose force over a step, F = -sum w p dg at the middle of the step, does exactly the work
// -(psi(g1) - psi(g0)) (T. A. Laursen, V. Chawla, Int. J. Numer. Meth. Engng. 40 (1997)). The gaps of closed
// constraints are accumulated, g1 = g0 + dg.du (step_rule.cpp), because the change of a curved gap is its
// middle gradient times du only to third order. The trapezoidal rule balances forces at the ends of the step
// and moves the bodies by the mean of two ends: 2 F - f_n takes the place of the force of the end, so that
// the mean is F.
class ConservingPenalty : public EnforcementMethod {
public:
  using EnforcementMethod::EnforcementMethod;
  void press(Constraint& c) const override {
    if (!c.works_exactly()) return EnforcementMethod::press(c);
    c.pressure = secant_pressure(eps(), c.start_gap, c.gap).p;
    c.active = c.pressure > 0;
  }
  double stiffness(const Constraint& c) const override {
    return c.works_exactly() ? -2 * secant_pressure(eps(), c.start_gap, c.gap).slope
                             : EnforcementMethod::stiffness(c);
  }
};

} // namespace

std::unique_ptr<EnforcementMethod> make_penalty(const ContactSettings& settings, const EnforcementRows& rows,
                                                bool conserving) {
  // p = <-eps g> (75'): multipliers stay zero, what is left of the gap is p / eps.
  if (!conserving) return std::make_unique<EnforcementMethod>(settings, rows);
  return std::make_unique<ConservingPenalty>(settings, rows);
}

} // namespace impact
