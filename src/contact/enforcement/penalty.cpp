#include <cmath>
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

// A penalty of explicit steps. An automatic one, as soft as the cells' step asks for, stiffens where few
// points press all of a body: p = <lambda - eps g> + eps <-g>^3/s^2 (78''').
class StiffeningPenalty : public EnforcementMethod {
public:
  using EnforcementMethod::EnforcementMethod;
  void press(Constraint& c) const override {
    EnforcementMethod::press(c);
    if (c.active && c.gap < 0) c.pressure -= eps() * c.gap * square(c);
  }
  double stiffness(const Constraint& c) const override {
    return eps() * (1 + (c.gap < 0 ? 3 * square(c) : 0));
  }
  double potential(const Constraint& c) const override {
    return EnforcementMethod::potential(c) + (c.gap < 0 ? eps() * c.gap * c.gap * square(c) / 4 : 0);
  }
  double depth(double potential) const override {
    const double linear = EnforcementMethod::depth(potential), s = twice();
    return s > 0 ? s * std::sqrt(std::sqrt(1 + 2 * std::pow(linear / s, 2)) - 1) : linear;
  }

private:
  double twice() const { return rows_.penalty->trial[EnforcementRows::stiffens_at]; } // as stiff
  double square(const Constraint& c) const { return twice() > 0 ? std::pow(c.gap / twice(), 2) : 0; }
};

} // namespace

std::unique_ptr<EnforcementMethod> make_penalty(const ContactSettings& settings, const EnforcementRows& rows,
                                                bool conserving) {
  // p = <-eps g> (75'): multipliers stay zero, what is left of the gap is p / eps.
  if (conserving) return std::make_unique<ConservingPenalty>(settings, rows);
  if (!settings.iterated) return std::make_unique<StiffeningPenalty>(settings, rows);
  return std::make_unique<EnforcementMethod>(settings, rows);
}

} // namespace impact
