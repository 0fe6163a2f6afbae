#include <impact/contact/enforcement.hpp>

namespace impact {

namespace {

// Pressures and tractions are what ContactImpulses found at the end of the step; no energy is kept in them.
class GivenPressure : public EnforcementMethod {
public:
  using EnforcementMethod::EnforcementMethod;
  bool is_given() const override { return true; }
  bool has_multipliers() const override { return true; }
  bool presses(int index, double) const override { return rows_.lambda(index) > 0; }
  void press(Constraint& c) const override {
    c.lambda = c.pressure = rows_.lambda(c.index);
    c.active = c.pressure > 0;
  }
  double stiffness(const Constraint&) const override { return 0; }
  double potential(const Constraint&) const override { return 0; }
};

} // namespace

std::unique_ptr<EnforcementMethod> make_impulse(const ContactSettings& settings,
                                                const EnforcementRows& rows) {
  return std::make_unique<GivenPressure>(settings, rows);
}

} // namespace impact
