#pragma once
#include <impact/contact/enforcement.hpp>

/// An enforcement of one's own: a penalty that stiffens with the depth d = <-g>,
///   psi = eps (d^2/2 + d^4/(4 s^2)),  p = eps d (1 + (d/s)^2),  -dp/dg = eps (1 + 3 (d/s)^2).
class StiffeningPenalty : public impact::EnforcementMethod {
public:
  StiffeningPenalty(const impact::ContactSettings& settings, const impact::EnforcementRows& rows,
                    double depth)
      : EnforcementMethod(settings, rows), depth_(depth) {}

  bool presses(int /*index*/, double gap) const override { return gap < 0; }
  void press(impact::Constraint& c) const override {
    c.active = c.gap < 0;
    c.pressure = c.active ? -eps() * c.gap * (1 + square(c)) : 0;
  }
  double stiffness(const impact::Constraint& c) const override { return eps() * (1 + 3 * square(c)); }
  double potential(const impact::Constraint& c) const override {
    return c.gap < 0 ? eps() * c.gap * c.gap * (0.5 + square(c) / 4) : 0;
  }

private:
  double square(const impact::Constraint& c) const { return c.gap * c.gap / (depth_ * depth_); }

  double depth_;
};
