#pragma once
#include <impact/contact/enforcement.hpp>

namespace impact {

/// p = <-eps g> (75'): multipliers stay zero, what is left of the gap is p / eps.
class Penalty : public EnforcementMethod {
public:
  using EnforcementMethod::EnforcementMethod;
};

/// A penalty whose force over a step, F = -sum w p dg at the middle of the step, does exactly the work
/// -(psi(g1) - psi(g0)) (T. A. Laursen, V. Chawla, Int. J. Numer. Meth. Engng. 40 (1997)). The gaps of closed
/// constraints are accumulated, g1 = g0 + dg.du (step_rule.cpp), because the change of a curved gap is its
/// middle gradient times du only to third order. The trapezoidal rule balances forces at the ends of the step
/// and moves the bodies by the mean of two ends: 2 F - f_n takes the place of the force of the end, so that
/// the mean is F.
class ConservingPenalty : public Penalty {
public:
  using Penalty::Penalty;
  void press(Constraint& c) const override;
  double stiffness(const Constraint& c) const override;
};

} // namespace impact
