#pragma once
#include "evaluate_point.hpp"
#include "reference_law.hpp"

#include <impact/material/cohesive.hpp>
#include <impact/material/point_law.hpp>

namespace reference {

/// Hardening, softening and rate of kind k; 0 is what aluminium() has.
inline constexpr int hardening_kinds = 8;
inline void set_hardening(MaterialParameters& m, int k) {
  using namespace impact;
  static const HardeningTable table({{0.0, 3.5e8}, {0.01, 4.2e8}, {0.02, 4.1e8}, {0.06, 5e8}});
  switch (k) {
  case 1:
    m.linear_h = 1e9;
    break;
  case 2:
    m.hardening = HardeningKind::power;
    m.power_b = 4e8, m.power_n = 0.168;
    break;
  case 3:
    m.hardening = HardeningKind::table;
    m.table = &table;
    break;
  case 4:
    m.rate_c = 0.02, m.rate_0 = 3;
    break;
  case 5:
    m.softening = Softening::linear;
    m.softening_w = 2e-3;
    break;
  case 6: // Johnson and Cook, all of it
    set_hardening(m, 2);
    m.rate_c = 0.0089, m.rate_0 = 1;
    m.softening = Softening::johnson_cook;
    m.theta_ref = 293, m.theta_melt = 1000, m.softening_m = 1.1;
    break;
  case 7:
    set_hardening(m, 3);
    m.softening = Softening::johnson_cook;
    m.theta_ref = 310, m.theta_melt = 900, m.softening_m = 0.7;
    m.rate_c = 0.05, m.rate_0 = 10, m.rate_form = RateForm::power;
    break;
  }
}

/// An equation of state like that of aluminium, with and without heat.
inline void set_state(MaterialParameters& m, bool heats) {
  m.equation_of_state = impact::EquationOfState::mie_grueneisen;
  m.eos_s = 1.339;
  m.eos_gamma = heats ? 2 : 0;
  m.c_v = heats ? 2.43e6 : 0;
  m.alpha_t = heats ? m.eos_gamma * m.c_v / (3 * m.K) : 0;
}

/// The strength of a law whose ge knows one.
inline void set_strength(MaterialParameters& m, double strength) {
  m.cohesive = impact::cohesive_shape(m, 1);
  m.cohesive.a1 = impact::cohesive_slope(m, strength);
}

/// Random states of a point.
struct Sampler : TensorSampler {
  using TensorSampler::TensorSampler;
  template <int d> impact::PointHistory<double, d> history(double size) {
    return {unimodular<d>(size), uniform(0, 0.05)};
  }
};

} // namespace reference
