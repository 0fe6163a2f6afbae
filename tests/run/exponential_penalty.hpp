#pragma once
#include <cmath>
#include <impact/contact/enforcement.hpp>

/// An enforcement of one's own: a penalty whose pressure grows exponentially with the depth d = <-g>,
///   psi = eps s (s (e^{d/s} - 1) - d),  p = eps s (e^{d/s} - 1),  -dp/dg = eps e^{d/s}.
class ExponentialPenalty : public impact::EnforcementMethod {
public:
  ExponentialPenalty(const impact::ContactSettings& settings, const impact::EnforcementRows& rows,
                     double scale)
      : EnforcementMethod(settings, rows), scale_(scale) {}

  bool presses(int /*index*/, double gap) const override { return gap < 0; }
  void press(impact::Constraint& c) const override {
    c.active = c.gap < 0;
    c.pressure = c.active ? eps() * scale_ * std::expm1(-c.gap / scale_) : 0;
  }
  double stiffness(const impact::Constraint& c) const override { return eps() * std::exp(-c.gap / scale_); }
  double potential(const impact::Constraint& c) const override {
    return c.gap < 0 ? eps() * scale_ * (scale_ * std::expm1(-c.gap / scale_) + c.gap) : 0;
  }

private:
  double scale_;
};
